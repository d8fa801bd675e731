# Debian's compiler for 32-bit Arm with a floating-point unit (armv7-a, VFPv3-D16, Thumb-2);
# docs/performance.md, "On Arm", has the command.
set(CMAKE_SYSTEM_PROCESSOR armv7l)
set(debian_cross_triplet arm-linux-gnueabihf)
set(debian_cross_emulator qemu-arm)
# GCC notes where it passes an argument otherwise than before version 7.1. Everything here is built
# by one compiler, so nothing can disagree.
set(CMAKE_CXX_FLAGS_INIT -Wno-psabi)
include(${CMAKE_CURRENT_LIST_DIR}/debian-cross.cmake)
