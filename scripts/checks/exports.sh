#!/usr/bin/env bash
# Other projects use the package:  scripts/checks/exports.sh
#
# Builds and installs without catkin, with shared and with static libraries, and in a catkin
# workspace. A project of each kind (test/consumer) is built and run against each installation and
# against the devel space. Installations are used from another place than the one they were made for,
# with everything that they were built from out of sight. The last line says what was found.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
# Not in the package: roslaunch and rosrun would find what is installed there a second time.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Of the caller's environment only what ccache is told.
mapfile -t ccache < <(env | grep '^CCACHE_')
clean() { # command...
  env -i HOME="$HOME" PATH=/usr/bin:/bin "${ccache[@]}" "$@"
}

# In the environment of a catkin space; that of Ubuntu's ROS for a new workspace.
within() { # directory with a setup.bash, command...
  # shellcheck disable=SC2016
  clean bash -c 'space=$1; shift; [ ! -f "$space/setup.bash" ] || . "$space/setup.bash"; "$@"' _ "$@"
}

# No file that CMake or pkg-config reads, and no run path, leads to the sources or to a build; the
# place for which catkin installs is written into its own files, and those are found elsewhere too.
paths_in() { # installation, place it was made for
  grep -rFn --include='*.cmake' --include='*.pc' "$root" "$1" | grep -vF "$2" && return 1
  find "$1" -type f \( -name '*.so' -o -perm -u+x \) -exec readelf -d {} + 2>/dev/null |
    grep 'R.*PATH' | grep -F "$root" && return 1
  return 0
}

# The lines of the page are those of the projects.
page_has() { # CMakeLists.txt
  local line
  while IFS= read -r line; do
    case $line in '' | '#'*) continue ;; esac
    grep -qxF "    ${line/..\/main.cpp/main.cpp}" "$root/docs/library.md" || {
      echo "docs/library.md is without the line of $1: $line"
      return 1
    }
  done <"$1"
}

consume() { # name, command... that prepares the build directory $work/NAME with the program consumer
  local name=$1 program
  shift
  echo "== $name"
  "$@"
  program=$(find "$work/$name" -name consumer -type f -perm -u+x -not -path '*/CMakeFiles/*')
  clean "$program" "$root/config/paper_simulation.yaml" "$work/$name/log.csv" | tee -a "$work/said"
}

plain_project() { # name, installation
  clean cmake -S "$root/test/consumer/plain" -B "$work/$1" -DCMAKE_PREFIX_PATH="$2" &&
    clean cmake --build "$work/$1"
}

# As plain_project, told of the installation by its environment.
plain_project_within() { # name, installation
  within "$2" cmake -S "$root/test/consumer/plain" -B "$work/$1" && clean cmake --build "$work/$1"
}

catkin_project() { # name, space
  mkdir -p "$work/$1/src"
  ln -s "$root/test/consumer" "$work/$1/src/consumer"
  (cd "$work/$1" && within "$2" catkin_make -DPYTHON_EXECUTABLE=/usr/bin/python3)
  within "$2" "$work/$1/devel/lib/ring_gyro_consumer/message_consumer"
}

installation() { # shared or static, argument of cmake
  echo "== without ROS, $1"
  clean cmake -S "$root" -B "$work/$1-build" -DRING_GYRO_ROS=OFF -DCMAKE_DISABLE_FIND_PACKAGE_catkin=ON \
    -DCMAKE_INSTALL_PREFIX="$work/$1-made" -DCMAKE_CXX_COMPILER_LAUNCHER=ccache "$2"
  clean cmake --build "$work/$1-build" --parallel "$(nproc)"
  clean cmake --install "$work/$1-build" >/dev/null
  mv "$work/$1-made" "$work/$1-moved"
  rm -r "$work/$1-build"
  paths_in "$work/$1-moved" no-place
  clean "$work/$1-moved/bin/tune_modes" --help >/dev/null
}

page_has "$root/test/consumer/plain/CMakeLists.txt"
page_has "$root/test/consumer/catkin/CMakeLists.txt"

for libraries in shared static; do
  argument=-DBUILD_SHARED_LIBS=ON
  [ "$libraries" = shared ] || argument=-DBUILD_SHARED_LIBS=OFF
  installation "$libraries" "$argument"
  consume "plain-$libraries" plain_project "plain-$libraries" "$work/$libraries-moved"
done

# The package as a link, as a user has it in a workspace, with the other package beside it.
echo "== catkin workspace"
mkdir -p "$work/workspace/src"
ln -s "$root" "$work/workspace/src/ring_gyro"
ln -s "$root/test/consumer" "$work/workspace/src/consumer"
workspace() {
  (cd "$work/workspace" &&
    within /opt/ros/noetic catkin_make install -j"$(nproc)" -DCMAKE_BUILD_TYPE=Release \
      -DCATKIN_ENABLE_TESTING=OFF -DPYTHON_EXECUTABLE=/usr/bin/python3 \
      -DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
}
consume workspace workspace
consume catkin-devel catkin_project catkin-devel "$work/workspace/devel"

mv "$work/workspace/install" "$work/catkin-moved"
rm -r "$work/workspace"
paths_in "$work/catkin-moved" "$work/workspace/install"
consume catkin-install catkin_project catkin-install "$work/catkin-moved"
consume plain-ros plain_project_within plain-ros "$work/catkin-moved"
# shellcheck disable=SC2016
within "$work/catkin-moved" bash -c 'cd / && rosrun ring_gyro simulate --duration 1 \
  --config "$(rospack find ring_gyro)/config/paper_simulation.yaml"'

[ "$(sort -u "$work/said" | wc -l)" -eq 1 ] || { echo "the projects differ"; exit 1; }
echo "$(wc -l <"$work/said") projects built and run (plain CMake against shared and static libraries" \
  "without ROS and against ROS, catkin in one workspace, against devel and install space): each says" \
  "$(sort -u "$work/said")"
