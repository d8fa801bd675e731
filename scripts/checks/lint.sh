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

found=()
echo "== shellcheck ${shell[*]}"
shellcheck --external-sources "${shell[@]}" || found+=(shellcheck)
echo "== pyflakes3 ${python[*]}"
pyflakes3 "${python[@]}" || found+=(pyflakes3)
echo "== catkin_lint --offline"
catkin_lint --offline -W0 . || found+=(catkin_lint)
[ ${#found[@]} -eq 0 ] || { echo "${found[*]} found something, see the log"; exit 1; }
echo "${#shell[@]} shell scripts, ${#python[@]} Python files and the catkin package: nothing found"
