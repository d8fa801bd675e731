#!/usr/bin/env bash
# Data races in the graph of nodelets in one process, with compensation, and in the recorder: all that is
# ours in them is built with ThreadSanitizer. The race of a nodelet that has one (test/threads) must be
# found by the same means, so that silence means something.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
work=$root/build/checks/thread_sanitizer
# The fences that GCC warns of are in headers of Boost.Asio.
cmake -S "$root" -B "$work" -DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_FLAGS="-O1 -g1 -Wno-tsan" \
  -DRING_GYRO_SANITIZE=thread -DCATKIN_ENABLE_TESTING=OFF -DPYTHON_EXECUTABLE=/usr/bin/python3 \
  -DCMAKE_CXX_COMPILER_LAUNCHER=ccache
cmake --build "$work" --parallel "$(nproc)" --target ring_gyro_nodelets bag_recorder_node nodelet_loader
set +u
# shellcheck source=/dev/null
. "$work/devel/setup.bash"
set -u
# The sanitizer of GCC before 14 does not start where the kernel spreads addresses wider than it knows.
same_addresses=()
if setarch "$(uname -m)" --addr-no-randomize true 2>/dev/null; then
  same_addresses=(setarch "$(uname -m)" --addr-no-randomize)
fi

run() { # name, seeded_race or nothing
  local out=$work/$1 port
  echo "== $1"
  rm -rf "$out"
  mkdir -p "$out"
  port=$("$root/scripts/free_ports.py")
  # Libraries without the sanitizer, as ROS's own: their locks are seen, what they read and write is
  # not. That is exact enough to need no suppressions, so there are none.
  ROS_LOG_DIR=$out/ros_log ROS_HOSTNAME=localhost ROS_MASTER_URI=http://localhost:$port \
    TSAN_OPTIONS="ignore_noninstrumented_modules=1 log_path=$out/report" \
    timeout -s INT 300 "${same_addresses[@]}" roslaunch -p "$port" "$root/test/threads/graph.launch" \
    bag:="$out/run.bag" seeded_race:="${2:-}" 2>&1
  [ -s "$out/run.bag" ] || { echo "$1: the run was cut, there is no $out/run.bag"; return 1; }
}

reports() { # name; prints them
  find "$work/$1" -name 'report.*' -exec cat {} +
}

run loop
reports loop
if reports loop | grep -q 'WARNING: ThreadSanitizer'; then
  echo "$(reports loop | grep -c 'WARNING: ThreadSanitizer') reports on the loop, see the log"
  exit 1
fi
run seeded_race seeded_race
reports seeded_race
reports seeded_race | grep -q 'SUMMARY: ThreadSanitizer: data race .*/nodelet_loader.cpp' || {
  echo "the race of test/threads/nodelet_loader.cpp was not found, so nothing is known of the loop"
  exit 1
}
found=$(/usr/bin/python3 - "$work/loop/run.bag" <<'PYTHON'
import sys

import rosbag

bag = rosbag.Bag(sys.argv[1])
decisions = [message for _, message, _ in bag.read_messages("compensation_gains")]
if not decisions or decisions[-1].state != decisions[-1].TRACKING:
    sys.exit(f"the last of {len(decisions)} decisions does not track the estimate: the run is too short")
print(f"{decisions[-1].header.stamp.to_sec() - decisions[0].header.stamp.to_sec():.0f} s "
      f"with {len(decisions)} decisions, the last of them tracking")
PYTHON
)
echo "no report in $found; the seeded race is found"
