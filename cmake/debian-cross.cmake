# What the toolchain files of Debian's cross compilers share; they set `debian_cross_triplet` and
# `debian_cross_emulator`. Packages: g++-TRIPLET, qemu-user, and of the build machine libeigen3-dev,
# libboost-dev.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_C_COMPILER ${debian_cross_triplet}-gcc)  # for GoogleTest
set(CMAKE_CXX_COMPILER ${debian_cross_triplet}-g++)
set(CMAKE_CROSSCOMPILING_EMULATOR ${debian_cross_emulator} -L /usr/${debian_cross_triplet})

# Eigen and Boost are headers for any processor, but lie in /usr/include among those of the build
# machine's C library, which the cross compiler must not see: they alone are linked into a root of
# their own.
set(debian_cross_headers ${CMAKE_BINARY_DIR}/cross_headers)
foreach(tree include/boost include/eigen3 share/eigen3)
  if(NOT EXISTS /usr/${tree})
    message(FATAL_ERROR "There is no /usr/${tree}: install libeigen3-dev and libboost-dev")
  endif()
  if(NOT EXISTS ${debian_cross_headers}/usr/${tree})
    get_filename_component(folder ${debian_cross_headers}/usr/${tree} DIRECTORY)
    file(MAKE_DIRECTORY ${folder})
    file(CREATE_LINK /usr/${tree} ${debian_cross_headers}/usr/${tree} SYMBOLIC)
  endif()
endforeach()
set(CMAKE_FIND_ROOT_PATH /usr/${debian_cross_triplet} ${debian_cross_headers})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
