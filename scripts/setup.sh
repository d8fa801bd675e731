#!/usr/bin/env bash
# Installs what the package needs to build, run and be tested, and nothing that is there already.
# Sourced it sets the environment too. Its argument:
#   --run        what building and running need
#   --tests      what the tests need besides (as without an argument)
#   --benchmark  what scripts/benchmark.sh needs besides --run
#   --checks     what scripts/check_all.sh needs besides --tests
# Debian 12 (ROS from Debian's own packages) or Ubuntu 20.04 (ROS Noetic, /opt/ros/noetic).

setup_fail() {
  printf 'setup: %s\n' "$1" >&2
  return 1
}

setup_packages() { # tests, benchmark, checks: yes or no each
  local id version
  # shellcheck source=/dev/null
  id=$(. /etc/os-release && printf '%s' "$ID")
  # shellcheck source=/dev/null
  version=$(. /etc/os-release && printf '%s' "${VERSION_ID:-}")
  printf '%s\n' build-essential cmake ccache libeigen3-dev libhdf5-dev libmatio-dev pkg-config libyaml-cpp-dev libboost-dev \
    libboost-program-options-dev libboost-filesystem-dev nlohmann-json3-dev python3 python3-numpy python3-matplotlib \
    python3-setuptools python3-yaml zlib1g-dev
  case "$id-$version" in
    debian-*)
      printf '%s\n' catkin ros-core-dev ros-base-dev rosbash libdiagnostic-updater-dev \
        libnodeletlib-dev libnodeletlib-tools libbondcpp-dev pluginlib-dev ros-message-generation \
        librosbag-dev librosbag-storage-dev libsensor-msgs-dev libstd-srvs-dev \
        libros-rosgraph-msgs-dev python3-rosbag python3-roslaunch python3-rosmaster python3-rosnode \
        python3-rosparam python3-rospy python3-rostopic python3-rosservice rosout \
        python3-diagnostic-msgs python3-sensor-msgs python3-std-srvs
      [ "$1" = no ] || printf '%s\n' librostest-dev python3-rostest
      ;;
    ubuntu-20.04)
      printf '%s\n' ros-noetic-ros-base ros-noetic-diagnostic-updater ros-noetic-nodelet \
        ros-noetic-pluginlib ros-noetic-rosbag ros-noetic-sensor-msgs ros-noetic-std-srvs
      [ "$1" = no ] || printf '%s\n' ros-noetic-rostest
      ;;
    *)
      setup_fail "$id $version is not supported: Debian 12 or Ubuntu 20.04 is needed"
      return 1
      ;;
  esac
  [ "$1" = no ] || printf '%s\n' libgtest-dev clang-format parallel
  # The Octave of Debian and Ubuntu holds octave-cli.
  [ "$2" = no ] || printf '%s\n' libbenchmark-dev octave util-linux
  [ "$3" = no ] || printf '%s\n' catkin-lint clang clang-tidy g++-aarch64-linux-gnu \
    g++-arm-linux-gnueabihf pyflakes3 python3-sympy qemu-user shellcheck util-linux valgrind
}

setup_missing() { # packages... ; prints those that are not installed
  local package
  for package in "$@"; do
    # shellcheck disable=SC2016
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] ||
      printf '%s\n' "$package"
  done
}

setup_apt() {
  if [ "$(id -u)" -eq 0 ]; then
    DEBIAN_FRONTEND=noninteractive apt-get "$@"
  elif command -v sudo >/dev/null 2>&1; then
    sudo DEBIAN_FRONTEND=noninteractive apt-get "$@"
  else
    setup_fail "packages are missing and neither root nor sudo is at hand to install them"
  fi
}

setup_main() {
  local tests benchmark=no checks=no list
  local -a packages missing
  case "${1:---tests}" in
    --run) tests=no ;;
    --tests) tests=yes ;;
    --benchmark) tests=no benchmark=yes ;;
    --checks) tests=yes checks=yes ;;
    *)
      setup_fail "unknown argument $1 (usage: setup.sh [--run | --tests | --benchmark | --checks])"
      return 1
      ;;
  esac
  command -v apt-get >/dev/null 2>&1 || {
    setup_fail "apt-get is needed (Debian 12 or Ubuntu 20.04)"
    return 1
  }
  list=$(setup_packages "$tests" "$benchmark" "$checks") || return 1
  mapfile -t packages <<<"$list"
  list=$(setup_missing "${packages[@]}")
  if [ -n "$list" ]; then
    mapfile -t missing <<<"$list"
    printf 'setup: installing %d packages: %s\n' "${#missing[@]}" "${missing[*]}"
    setup_apt update -qq || setup_fail "apt-get update failed: is the network there?" || return 1
    setup_apt install -y -qq --no-install-recommends "${missing[@]}" >/dev/null ||
      setup_fail "apt-get could not install: ${missing[*]}" || return 1
  fi

  # The interpreter that has rospy is the system's; another python3 may stand first on PATH.
  export PATH="/usr/bin:$PATH"
  unset ROS_IP
  export ROS_HOSTNAME=localhost
  if [ -f /opt/ros/noetic/setup.bash ]; then
    case $- in
      *u*)
        set +u
        # shellcheck source=/dev/null
        . /opt/ros/noetic/setup.bash
        set -u
        ;;
      *)
        # shellcheck source=/dev/null
        . /opt/ros/noetic/setup.bash
        ;;
    esac
  fi
}

setup_main "$@"
