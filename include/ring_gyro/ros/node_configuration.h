#pragma once

#include <ros/node_handle.h>
#include <yaml-cpp/yaml.h>

#include "ring_gyro/configuration/configuration_reader.h"

namespace ring_gyro::bridge {

/// The parameters of a node: the configuration that the tools also read, and the section `node`.
struct NodeConfiguration {
  cvg::LoopConfiguration loop;
  cvg::NodeParameters node;
};

/// All parameters in the namespace of `private_handle`, except those that belong to ROS packages.
YAML::Node parametersOf(const ros::NodeHandle& private_handle);

/// Reads and checks the private parameters of a node. Throws ConfigurationError, and
/// std::runtime_error when an output is the same file as an input or as another output.
NodeConfiguration readNodeConfiguration(const ros::NodeHandle& private_handle);

}  // namespace ring_gyro::bridge
