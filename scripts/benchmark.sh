#!/usr/bin/env bash
# Every measurement against its peer:  scripts/benchmark.sh [--quick] [options of benchmark/measure.py]
#
# Sets up, builds as scripts/build.sh does by default (no option for this very processor), runs all
# rows, prints the table and writes it to docs/performance.md. --quick takes some minutes, the whole
# about half an hour and 5 GB below build/benchmark. With --only nothing is written.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh" --benchmark

build=$root/build/benchmark
launcher=()
if command -v ccache >/dev/null 2>&1; then
  launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
mkdir -p "$build"
{
  cmake -S "$root" -B "$build" -DCMAKE_BUILD_TYPE=Release -DCATKIN_ENABLE_TESTING=OFF \
    -DRING_GYRO_BENCHMARKS=ON -DPYTHON_EXECUTABLE=/usr/bin/python3 "${launcher[@]}" &&
    cmake --build "$build" --parallel "$(nproc)"
} >"$build/build.log" 2>&1 || {
  tail -n 30 "$build/build.log" >&2
  exit 1
}
set +u
# shellcheck source=/dev/null
. "$build/devel/setup.bash"
set -u

output=(--output "$root/docs/performance.md")
for argument in "$@"; do
  [ "$argument" != --only ] || output=()
done
exec /usr/bin/python3 "$root/benchmark/measure.py" "$build/devel/lib/ring_gyro" \
  --work "$build/runs" "${output[@]}" "$@"
