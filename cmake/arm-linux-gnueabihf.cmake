# Debian's compiler for 32-bit Arm with a floating-point unit (armv7-a, VFPv3-D16, Thumb-2):
#   cmake --toolchain cmake/arm-linux-gnueabihf.cmake -DRING_GYRO_CORE_ONLY=ON -DBUILD_TESTING=ON
set(CMAKE_SYSTEM_PROCESSOR armv7l)
set(debian_cross_triplet arm-linux-gnueabihf)
set(debian_cross_emulator qemu-arm)
# Everything is built by one compiler: what earlier ones did otherwise (64-bit members by value) need
# not be told.
set(CMAKE_CXX_FLAGS_INIT -Wno-psabi)
include(${CMAKE_CURRENT_LIST_DIR}/debian-cross.cmake)
