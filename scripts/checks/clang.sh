#!/usr/bin/env bash
# Builds everything, tests too, by clang with its warnings as errors. Not optimized: what clang warns of
# does not depend on that, and it takes half the time. Some tests silence warnings that only GCC has.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
work=$root/build/checks/clang
cmake -S "$root" -B "$work" -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=None \
  -DCMAKE_CXX_FLAGS="-O0 -Wno-unknown-warning-option" -DRING_GYRO_WARNINGS_AS_ERRORS=ON \
  -DCATKIN_ENABLE_TESTING=ON -DPYTHON_EXECUTABLE=/usr/bin/python3 \
  -DCMAKE_CXX_COMPILER_LAUNCHER=ccache
# All that is wrong at once, not the first.
cmake --build "$work" --parallel "$(nproc)" -- --keep-going
cmake --build "$work" --parallel "$(nproc)" --target tests -- --keep-going
"$work/devel/lib/ring_gyro/simulate" --config "$root/config/paper_simulation.yaml" --duration 1
echo "$(clang++ --version | head -n 1): everything builds, tests too, without a warning, and simulate runs"
