#!/usr/bin/env bash
# clang-tidy over all sources of src and the headers that they include, with the list of .clang-tidy.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
work=$root/build/checks/clang_tidy
cmake -S "$root" -B "$work" -DCMAKE_CXX_COMPILER=clang++ -DCATKIN_ENABLE_TESTING=OFF \
  -DCMAKE_EXPORT_COMPILE_COMMANDS=ON -DPYTHON_EXECUTABLE=/usr/bin/python3
cmake --build "$work" --target ring_gyro_generate_messages_cpp

cd "$root"
mapfile -t sources < <(git ls-files --cached --others --exclude-standard 'src/*.cpp')
status=0
printf '%s\0' "${sources[@]}" |
  xargs -0 -n 1 -P "$(nproc)" clang-tidy -p "$work" --quiet \
    >"$work/found.log" 2>"$work/counts.log" || status=$?
# A header's fault is found from every source that includes it.
grep -E ': (warning|error): ' "$work/found.log" | sort | uniq -c || true
[ "$status" -eq 0 ] || {
  tail -n 20 "$work/counts.log"
  echo "clang-tidy found something, all of it with its lines is in build/checks/clang_tidy/found.log"
  exit 1
}
checks=$(clang-tidy --list-checks | grep -c '^    ')
echo "${#sources[@]} sources and their headers, $checks checks: nothing found"
