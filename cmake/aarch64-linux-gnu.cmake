# Debian's compiler for 64-bit Arm; docs/performance.md, "On Arm", has the command.
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(debian_cross_triplet aarch64-linux-gnu)
set(debian_cross_emulator qemu-aarch64)
include(${CMAKE_CURRENT_LIST_DIR}/debian-cross.cmake)
