# Debian's compiler for 64-bit Arm:
#   cmake --toolchain cmake/aarch64-linux-gnu.cmake -DRING_GYRO_CORE_ONLY=ON -DBUILD_TESTING=ON
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(debian_cross_triplet aarch64-linux-gnu)
set(debian_cross_emulator qemu-aarch64)
include(${CMAKE_CURRENT_LIST_DIR}/debian-cross.cmake)
