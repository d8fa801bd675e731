#!/usr/bin/env bash
# The core on Arm:  scripts/checks/arm.sh
#
# Builds ring_gyro_core by Debian's compilers for 32-bit and 64-bit Arm, runs its short tests under
# qemu, and prints how many instructions a block of the loops and of the identifier takes there and on
# x86-64.
set -euo pipefail
shopt -s inherit_errexit
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
work=$root/build/checks/arm
export PATH=/usr/bin:$PATH # the compilers and qemu of Debian

build() { # name target cmake arguments...
  local name=$1 target=$2
  shift 2
  mkdir -p "$work"
  { cmake -S "$root" -B "$work/$name" -DRING_GYRO_CORE_ONLY=ON -DRING_GYRO_BENCHMARKS=ON \
    -DBUILD_SHARED_LIBS=OFF -DRING_GYRO_WARNINGS_AS_ERRORS=ON -DCMAKE_CXX_COMPILER_LAUNCHER=ccache \
    "$@" && cmake --build "$work/$name" --parallel "$(nproc)" --target "$target" block_cost
  } >"$work/$name.build.log" 2>&1 || { tail -n 20 "$work/$name.build.log"; return 1; }
}

# Prints how many test programs have passed.
tests() { # name
  local name=$1
  (cd "$work/$name" && ctest -L short --output-on-failure --parallel "$(nproc)") \
    >"$work/$name.tests.log" 2>&1 || { tail -n 40 "$work/$name.tests.log" >&2; return 1; }
  sed -n 's/.*tests passed, 0 tests failed out of //p' "$work/$name.tests.log"
}

# One instruction at a time, a line for each.
executed() { # program part blocks emulator...
  "${@:4}" -singlestep -d nochain,exec -D /dev/stdout "$1" "$2" "$3" | grep -c '^Trace'
}

# A hundred blocks: a period of the identifier.
instructions() { # name part emulator...
  local program=$work/$1/benchmark/block_cost few many
  few=$(executed "$program" "$2" 100 "${@:3}")
  many=$(executed "$program" "$2" 200 "${@:3}")
  echo $(((many - few) / 100))
}

row() { # part title
  counts=$(instructions x86-64 "$1" qemu-x86_64 -cpu qemu64)
  counts+=" $(instructions x86-64 "$1" qemu-x86_64 -cpu max)"
  counts+=" $(instructions arm-linux-gnueabihf "$1" qemu-arm -L /usr/arm-linux-gnueabihf)"
  counts+=" $(instructions aarch64-linux-gnu "$1" qemu-aarch64 -L /usr/aarch64-linux-gnu)"
  echo "| $2 | ${counts// / | } |"
}

build arm-linux-gnueabihf short_core_tests -DBUILD_TESTING=ON \
  -DCMAKE_TOOLCHAIN_FILE="$root/cmake/arm-linux-gnueabihf.cmake"
build aarch64-linux-gnu short_core_tests -DBUILD_TESTING=ON \
  -DCMAKE_TOOLCHAIN_FILE="$root/cmake/aarch64-linux-gnu.cmake"
build x86-64 block_cost -DCMAKE_CXX_COMPILER=x86_64-linux-gnu-g++
armhf=$(tests arm-linux-gnueabihf)
echo "armhf: $armhf test programs passed"
aarch64=$(tests aarch64-linux-gnu)
echo "aarch64: $aarch64 test programs passed"

echo '| instructions a block of 1 ms | x86-64, SSE2 | x86-64, AVX2 | armhf | aarch64 |'
echo '| --- | --- | --- | --- | --- |'
row loops 'demodulation and loops'
loops=${counts// /, }
row identifier 'identifier, an update every 100 blocks'
row identifier_each_block 'identifier, an update every block'
echo "armhf and aarch64: $armhf and $aarch64 test programs passed; a block of the loops takes $loops instructions (x86-64 with SSE2, with AVX2, armhf, aarch64)"
