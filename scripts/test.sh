#!/usr/bin/env bash
# Every test of the package:  scripts/test.sh
#
# Sets up and builds with warnings as errors; runs each gtest and rostest, the gtests of the core
# again with the address and undefined-behaviour sanitizers, the checks of format and floors, and
# the install space. The last line is "N passed, N failed"; logs and results are in build/test.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh" --tests || { echo "0 passed, 1 failed"; exit 1; }

work=$root/build/test
results=$work/results
# Not in the package: its launch files and programs would be found twice.
space=$(mktemp -d)
trap 'rm -rf "$space"' EXIT
rm -rf "$results"
mkdir -p "$results"
jobs=$(nproc)
common=(-DPYTHON_EXECUTABLE=/usr/bin/python3 -DRING_GYRO_WARNINGS_AS_ERRORS=ON
  -DCMAKE_CXX_COMPILER_LAUNCHER=ccache)

# check NAME COMMAND...: one test case by a command's exit status.
check() {
  local name=$1 status=0 start=$SECONDS
  shift
  "$@" >"$work/$name.log" 2>&1 </dev/null || status=$?
  local failure=''
  if [ "$status" -ne 0 ]; then
    failure="<failure message=\"status $status, see build/test/$name.log\"/>"
    printf '%s\n' "--- the end of build/test/$name.log:"
    tail -n 40 "$work/$name.log"
    printf '%s\n' "---"
  fi
  printf '<testsuite><testcase classname="check" name="%s" time="%d">%s</testcase></testsuite>\n' \
    "$name" $((SECONDS - start)) "$failure" >"$results/check_$name.xml"
  printf '%-22s %s, %d s\n' "$name" "$([ "$status" -eq 0 ] && echo ok || echo FAILED)" \
    $((SECONDS - start))
  return "$status"
}

# counted LABEL XML...: the sums so far, for whoever watches.
counted() {
  printf '%-22s %s\n' "$1" "$("$root/scripts/count_tests.py" "${@:2}" | tail -n 1)"
}

# shellcheck disable=SC2046
format() {
  cd "$root"
  clang-format --dry-run --Werror $(git ls-files 'src/*.h' 'src/*.cpp' 'include/*.h' 'test/*.h' \
    'test/*.cpp' 'benchmark/*.h' 'benchmark/*.cpp')
}

build_tests() {
  cmake -S "$root" -B "$work/release" -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_INSTALL_PREFIX="$space" "${common[@]}" &&
    cmake --build "$work/release" --parallel "$jobs" &&
    cmake --build "$work/release" --parallel "$jobs" --target tests
}

# catkin runs gtests and rostests and leaves a result file for each; one at a time, because lockstep
# runs are timed.
run_tests() {
  rm -rf "$work/release/test_results"
  set +u
  # shellcheck source=/dev/null
  . "$work/release/devel/setup.bash"
  set -u
  ROS_LOG_DIR=$work/ros_log cmake --build "$work/release" --target run_tests -- -j1
}

build_sanitized() {
  cmake -S "$root" -B "$work/sanitized" -DCMAKE_BUILD_TYPE=None \
    -DCMAKE_CXX_FLAGS="-O1 -g1 -Wno-maybe-uninitialized" \
    -DRING_GYRO_SANITIZE=address,undefined "${common[@]}" &&
    cmake --build "$work/sanitized" --parallel "$jobs" --target core_tests
}

sanitized_gtest() { # program
  ASAN_OPTIONS=detect_stack_use_after_return=1 \
    "$1" --gtest_output="xml:$results/sanitized_$(basename "$1").xml" >"$1.log" 2>&1 </dev/null
}

# Two at a time; a program that dies leaves no result file and is made a failure.
# shellcheck disable=SC2016
run_sanitized() {
  export results
  export -f sanitized_gtest
  find "$work/sanitized/devel/lib/ring_gyro" -name '*_test' -type f -print0 | sort -z |
    xargs -0 -P "$jobs" -I{} bash -c 'sanitized_gtest "$1"' _ {} || true
  local program name ran=0
  for program in "$work"/sanitized/devel/lib/ring_gyro/*_test; do
    name=$(basename "$program")
    ran=$((ran + 1))
    if ! /usr/bin/python3 -c 'import sys, xml.etree.ElementTree as e; e.parse(sys.argv[1])' \
      "$results/sanitized_$name.xml" 2>/dev/null; then
      tail -n 40 "$program.log"
      printf '<testsuite><testcase classname="sanitized" name="%s"><failure message="died"/></testcase></testsuite>\n' \
        "$name" >"$results/sanitized_$name.xml"
    fi
  done
  [ "$ran" -gt 0 ]
}

sanitized() {
  if check build_sanitized build_sanitized; then
    check run_sanitized run_sanitized || true
    counted 'with sanitizers' "$results"/sanitized_*.xml
  fi
}

# What users get, in a place of its own; it alone must run.
install_release() {
  cmake --build "$work/release" --target install
}

run_installed() { # command... in the environment of the install space
  env -i HOME="$HOME" PATH=/usr/bin:/bin ROS_HOSTNAME=localhost ROS_LOG_DIR="$work/ros_log" \
    ROS_MASTER_URI="http://localhost:$installed_port" bash -c \
    ". '$space/setup.bash' && cd / && \"\$@\"" _ "$@"
}

installed_simulate() {
  # shellcheck disable=SC2016
  run_installed bash -c 'rosrun ring_gyro simulate --output "$1" --duration 5 \
    --config "$(rospack find ring_gyro)/config/paper_simulation.yaml" &&
    rosrun ring_gyro summarise_run "$1" --json "$2/summary.json" --csv "$2" &&
    rosrun ring_gyro plot_run.py "$2"' _ "$work/installed.bag" "$work/installed_plots"
}

# A bag of an older version, made one of today by the rules that were installed.
installed_migration() {
  rm -f "$work/installed_migration.bag"
  # shellcheck disable=SC2016
  run_installed bash -c 'rosbag fix "$1" "$2" &&
    rosrun ring_gyro identify "$2" --preset paper_simulation' _ \
    "$root/test/baseline/run.bag" "$work/installed_migration.bag"
}

installed_launch() { # nodelets
  rm -f "$work/installed_launch.bag"
  run_installed timeout -s INT 120 roslaunch -p "$installed_port" ring_gyro simulation.launch \
    duration:=5 compensate:=true nodelets:="$1" record:="$work/installed_launch.bag" || return 1
  run_installed rosrun ring_gyro summarise_run "$work/installed_launch.bag"
}

# Messages and helpers are one Python package.
installed_python() {
  run_installed /usr/bin/python3 -c 'import ring_gyro.msg, ring_gyro.report_figures, ring_gyro.tools
import sys
sys.exit(not ring_gyro.tools.__file__.startswith(sys.argv[1]))' "$space"
}

# With the graph above, each nodelet there is has been loaded from the install space.
installed_calibration() {
  rm -f "$work/installed_calibration.yaml"
  run_installed timeout -s INT 240 roslaunch -p "$installed_port" ring_gyro calibration.launch \
    config:="$root/test/short_calibration.yaml" nodelets:=true \
    calibration:="$work/installed_calibration.yaml" || return 1
  [ -s "$work/installed_calibration.yaml" ]
}

check format format || true
check floors "$root/scripts/check_floors.py" || true
if check build build_tests; then
  # A graph in lockstep leaves most of the processors idle. The sanitized build and its tests, which
  # nobody times, take only what the graphs leave; a process group of their own, to be ended as one.
  set -m
  (renice -n 19 "$BASHPID" >/dev/null && sanitized) &
  beside=$!
  set +m
  trap 'kill -- "-$beside" 2>/dev/null; rm -rf "$space"' EXIT
  check run_tests run_tests || true
  grep -a -o '\[figure\].*' "$work/run_tests.log" || true
  counted 'gtests and rostests' "$work/release/test_results"
  wait "$beside" || true
  trap 'rm -rf "$space"' EXIT
else
  sanitized
fi
installed_port=$("$root/scripts/free_ports.py")
if check install install_release; then
  check installed_simulate installed_simulate || true
  check installed_migration installed_migration || true
  check installed_launch installed_launch false || true
  check installed_nodelets installed_launch true || true
  check installed_calibration installed_calibration || true
  check installed_python installed_python || true
fi

mkdir -p "$work/release/test_results"
"$root/scripts/count_tests.py" "$work/release/test_results" "$results"
