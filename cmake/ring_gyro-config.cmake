# find_package(ring_gyro) of an installation without ROS: ring_gyro::core, ring_gyro::configuration and
# ring_gyro::logs.
include(CMakeFindDependencyMacro)
find_dependency(Eigen3 NO_MODULE)
find_dependency(Threads)
find_dependency(yaml-cpp)
include(${CMAKE_CURRENT_LIST_DIR}/ring_gyro-targets.cmake)
