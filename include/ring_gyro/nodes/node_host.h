#pragma once

#include <functional>
#include <string>

namespace ring_gyro::nodes {

/// Requests of a node to the process that runs it: its own process or a nodelet manager.
struct NodeHost {
  /// The node has finished its work and left its topics.
  std::function<void()> finish;
  /// The run cannot continue: log this line as FATAL and exit with a non-zero code.
  std::function<void(const std::string&)> fail;
};

}  // namespace ring_gyro::nodes
