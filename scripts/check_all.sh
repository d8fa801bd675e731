#!/usr/bin/env bash
# The long checks that scripts/test.sh does not run:  scripts/check_all.sh [--write] [NAME...]
#
# NAME is a file of scripts/checks without its .sh; none: all of them. Prints a row for each; the last
# line is "N passed, N failed". What a check printed is in build/checks/NAME.log. With --write, or
# without any NAME, the last row of every check goes into docs/checks.md.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

write=no
if [ $# -eq 0 ]; then
  write=yes
elif [ "$1" = --write ]; then
  write=yes
  shift
fi
known=() names=("$@")
for script in "$root"/scripts/checks/*.sh; do
  known+=("$(basename "$script" .sh)")
done
[ ${#names[@]} -gt 0 ] || names=("${known[@]}")
for name in "${names[@]}"; do
  [ -x "$root/scripts/checks/$name.sh" ] || {
    echo "check_all: there is no check $name; there are: ${known[*]}" >&2
    exit 2
  }
done

# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh" --checks
work=$root/build/checks
mkdir -p "$work"

commit() {
  git -C "$root" rev-parse --short HEAD 2>/dev/null || { echo unknown; return; }
  # The page itself is what these checks write.
  [ -z "$(git -C "$root" status --porcelain -- . ':!docs/checks.md')" ] || echo 'with changes'
}

# Prints the row of one check and keeps it as a row of the page; status as the check's.
run() { # name
  local log=$work/$1.log start=$SECONDS status=0 verdict=ok finding seconds
  : >"$log"
  # shellcheck disable=SC2094
  finding=$("$root/scripts/checks/$1.sh" 2>>"$log" </dev/null | tee -a "$log" | tail -n 1) || status=$?
  seconds=$((SECONDS - start))
  if [ "$status" -ne 0 ]; then
    verdict=FAILED
    printf -- '--- the end of build/checks/%s.log:\n' "$1"
    tail -n 20 "$log"
    printf -- '---\n'
  fi
  printf '%-18s %-6s %5d s  %s\n' "$1" "$verdict" "$seconds" "$finding"
  # shellcheck disable=SC2016
  printf '| `%s` | %s | %d | %s, %s | %s |\n' "$1" "$verdict" "$seconds" "$(date +%F)" \
    "$(commit | paste -sd' ')" "${finding//|/\\|}" >"$work/$1.row"
  return "$status"
}

write_page() {
  local page=$root/docs/checks.md table=$work/table.md name
  local begin='<!-- table: scripts/check_all.sh -->' end='<!-- end of the table -->'
  {
    # shellcheck source=/dev/null
    printf '%s, %d cores, %s.\n\n' "$(sed -n 's/^model name[^:]*: *//p' /proc/cpuinfo | sort -u | paste -sd,)" \
      "$(nproc)" "$(. /etc/os-release && echo "$PRETTY_NAME")"
    printf '| check | result | seconds | when, commit | finding |\n| --- | --- | --- | --- | --- |\n'
    for name in "${known[@]}"; do
      # shellcheck disable=SC2016
      cat "$work/$name.row" 2>/dev/null || printf '| `%s` | not run | | | |\n' "$name"
    done
  } >"$table"
  awk -v begin="$begin" -v end="$end" -v table="$table" '
    $0 == end { print ""; inside = 0; found = 1 }
    !inside { print }
    $0 == begin { print ""; while ((getline line < table) > 0) print line; inside = 1 }
    END { exit !found || inside }' "$page" >"$work/checks.md" || {
    echo "check_all: docs/checks.md lacks the lines $begin and $end; put them back" >&2
    return 1
  }
  cat "$work/checks.md" >"$page"
}

passed=0 failed=0
for name in "${names[@]}"; do
  if run "$name"; then passed=$((passed + 1)); else failed=$((failed + 1)); fi
done
[ "$write" = no ] || write_page
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
