# ring_gyro::core, ring_gyro::configuration and ring_gyro::logs for whoever calls
# find_package(ring_gyro): without ROS this is the installation's ring_gyro-config.cmake; with ROS
# catkin's ring_gyroConfig.cmake includes it, in the devel space from the sources.
include(CMakeFindDependencyMacro)
find_dependency(Eigen3 NO_MODULE)
find_dependency(Threads)
find_dependency(yaml-cpp)
# In one catkin workspace, built as one, the libraries are targets already.
if(NOT TARGET ring_gyro::core)
  include(${ring_gyro_DIR}/ring_gyro-targets.cmake)
endif()

# Static libraries leave to whoever links them what shared ones bring along.
get_target_property(ring_gyro_library_type ring_gyro::core TYPE)
if(ring_gyro_library_type STREQUAL STATIC_LIBRARY)
  find_dependency(Boost)
  find_dependency(ZLIB)
  find_dependency(PkgConfig)
  pkg_check_modules(MATIO REQUIRED IMPORTED_TARGET matio)
  pkg_search_module(HDF5 REQUIRED IMPORTED_TARGET hdf5-serial hdf5)
endif()
