#!/usr/bin/env bash
# What can be found wrong with scripts, the package's description and Python without running them.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"

# Tracked and new files by their first line or their ending.
mapfile -t files < <(git ls-files --cached --others --exclude-standard)
shell=() python=()
for file in "${files[@]}"; do
  [ -f "$file" ] || continue
  IFS= read -r first <"$file" || true
  case $file:$first in
    *.sh:* | *:'#!'*sh) shell+=("$file") ;;
    *.py:* | *:'#!'*python*) python+=("$file") ;;
  esac
done

status=0
echo "== shellcheck ${shell[*]}"
shellcheck --external-sources "${shell[@]}" || status=1
echo "== pyflakes3 ${python[*]}"
pyflakes3 "${python[@]}" || status=1
echo "== catkin_lint --offline"
catkin_lint --offline . || status=1
[ "$status" -eq 0 ] || { echo "shellcheck, pyflakes3 or catkin_lint found something, see the log"; exit 1; }
echo "${#shell[@]} shell scripts, ${#python[@]} Python files and the catkin package: nothing found"
