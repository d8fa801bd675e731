#!/usr/bin/env bash
# Release build, with set-up:  scripts/build.sh [build directory] [cmake arguments...]
# Afterwards, unless another build directory was named:  . devel/setup.bash
# RING_GYRO_BUILD_LOG=FILE in the environment: the output goes there, a percentage is shown instead.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh" --run

build=$root/build
# Beside the build directory: rosrun looks at nothing below PACKAGE/build.
places=(-DCATKIN_DEVEL_PREFIX="$root/devel")
if [ $# -gt 0 ] && [ "${1#-}" = "$1" ]; then
  build=$1 places=()
  shift
fi
launcher=()
if command -v ccache >/dev/null 2>&1; then
  launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi

build_all() {
  cmake -S "$root" -B "$build" -DCMAKE_BUILD_TYPE=Release -DCATKIN_ENABLE_TESTING=OFF \
    -DPYTHON_EXECUTABLE=/usr/bin/python3 "${places[@]}" "${launcher[@]}" "$@"
  cmake --build "$build" --parallel "$(nproc)"
}

if [ -z "${RING_GYRO_BUILD_LOG:-}" ]; then
  build_all "$@"
elif [ -t 1 ]; then
  build_all "$@" 2>&1 | tee "$RING_GYRO_BUILD_LOG" |
    sed -u -n 's/^\(\[ *[0-9]*%\]\).*/\r\1 building/p' | tr -d '\n'
  printf '\r\033[K'
else
  build_all "$@" >"$RING_GYRO_BUILD_LOG" 2>&1
fi
