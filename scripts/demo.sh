#!/usr/bin/env bash
# The whole loop as ROS nodes: simulate, identify, compensate; then tables and plots of the run.
#
#   scripts/demo.sh [--preset NAME] [--duration SECONDS] [--nodelets] [--output DIRECTORY]
#
#   --preset    paper_simulation (default), paper_experiment, or another file of config/
#   --duration  simulated time, 130 s unless said; compensation begins half-way
#   --nodelets  all nodes in one process, which is faster
#   --output    where bag, tables and plots go; output/PRESET unless said
#
# Installs what is missing and builds first. Ends everything that it started.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

fail() {
  printf 'demo: %s\n' "$1" >&2
  exit 1
}

preset=paper_simulation duration=130 nodelets=false output=''
while [ $# -gt 0 ]; do
  option=$1
  shift
  case "$option" in
    --nodelets) nodelets=true ;;
    --preset | --duration | --output)
      [ $# -gt 0 ] || fail "$option needs a value"
      case "$option" in
        --preset) preset=$1 ;;
        --duration) duration=$1 ;;
        --output) output=$1 ;;
      esac
      shift
      ;;
    -h | --help)
      sed -n '2,/^set /s/^# \{0,1\}//p' "$0"
      exit 0
      ;;
    *) fail "unknown option $option; see --help" ;;
  esac
done
[ -f "$root/config/$preset.yaml" ] ||
  fail "no preset $preset; there are: $(cd "$root/config" && printf '%s ' *.yaml | sed 's/\.yaml//g')"
[[ $duration =~ ^[0-9]+(\.[0-9]+)?$ ]] || fail "--duration $duration: a number of seconds is needed"

output=$(realpath -m -- "${output:-$root/output/$preset}")
mkdir -p "$output" || fail "cannot make $output"
bag=$output/run.bag

# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh" --run || fail "set-up failed"
echo "building in $root/build (log: $output/build.log)"
RING_GYRO_BUILD_LOG=$output/build.log "$root/scripts/build.sh" || {
  grep -m 5 -iE 'error|not found' "$output/build.log" >&2 || true
  fail "the build failed; see $output/build.log"
}
set +u
# shellcheck source=/dev/null
. "$root/devel/setup.bash"
set -u

# A master of its own, on a free port of the loopback interface.
port=$("$root/scripts/free_ports.py")
export ROS_HOSTNAME=localhost ROS_MASTER_URI=http://localhost:$port ROS_LOG_DIR=$output/log
log=$output/roslaunch.log
launch_pid=''
end_launch() {
  [ -n "$launch_pid" ] || return 0
  local signal
  for signal in INT TERM KILL; do
    kill -0 "$launch_pid" 2>/dev/null || break
    kill -s "$signal" "$launch_pid" 2>/dev/null || break
    for _ in $(seq 40); do
      kill -0 "$launch_pid" 2>/dev/null || break 2
      sleep 0.5
    done
  done
  launch_pid=''
}
trap end_launch EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

plain() { # a line of a log without colours, level and time
  sed 's/\x1b\[[0-9;]*m//g; s/^\[ *[A-Z]*\] *\(\[[^]]*\]\)*: *//'
}

rm -f "$bag" "$bag".*.active
compensate_after=$(python3 -c "print(round(0.51 * $duration, 1))")
echo "simulating $duration s of $preset, compensation from $compensate_after s (log: $log)"
roslaunch -p "$port" ring_gyro simulation.launch preset:="$preset" duration:="$duration" \
  nodelets:="$nodelets" compensate:=true compensate_after:="$compensate_after" \
  record:="$bag" >"$log" 2>&1 </dev/null &
launch_pid=$!
shown='' idle=0
while kill -0 "$launch_pid" 2>/dev/null; do
  sleep 1
  line=$(grep -a -oE 'simulated [0-9.]+ of [0-9.]+ s, [0-9.]+ times real time' "$log" | tail -n 1 || true)
  if [ -n "$line" ] && [ "$line" != "$shown" ]; then
    if [ -t 1 ]; then printf '\r\033[K%s' "$line"; else printf '%s\n' "$line"; fi
    shown=$line idle=0
  fi
  idle=$((idle + 1))
  if [ "$idle" -gt 120 ]; then
    if [ -t 1 ]; then printf '\n'; fi
    fail "nothing has been simulated for two minutes: $(tail -n 1 "$log" | plain); see $log"
  fi
done
if [ -t 1 ]; then printf '\r\033[K'; fi
status=0
wait "$launch_pid" || status=$?
launch_pid=''
fatal=$(grep -a -m 1 '\[FATAL\]' "$log" | plain || true)
[ -z "$fatal" ] || fail "$fatal (see $log)"
[ "$status" -eq 0 ] || fail "roslaunch ended with status $status; see $log"
# The first process to end: the plant where the run was whole.
first=$(grep -a -m 1 -oE '\[[a-z_]+-[0-9]+\] has died' "$log" || true)
[ -f "$bag" ] || fail "the run was cut and left no bag${first:+: $first}; see $log"

# Status 2: the tables are there, and a line says what is not to be relied on.
status=0
rosrun ring_gyro summarise_run "$bag" --json "$output/summary.json" --csv "$output" \
  >"$output/summary.txt" || status=$?
[ "$status" -eq 0 ] || [ "$status" -eq 2 ] || fail "$bag cannot be summarised"
if grep -q '"cut": true' "$output/summary.json"; then
  fail "the run was cut before its end${first:+: $first}; what there is of it is in $bag, see $log"
fi
cat "$output/summary.txt"
echo
echo "plots:"
rosrun ring_gyro plot_run.py "$output" || fail "no plots"
echo "bag and tables: $bag $output/summary.txt $output/summary.json"
