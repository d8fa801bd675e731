#pragma once

#include <functional>
#include <string>

namespace ring_gyro::nodes {

/// What a node may ask of whatever runs it, a process of its own or a nodelet manager.
struct NodeHost {
  /// The node has done all it had to do and let go of its topics.
  std::function<void()> finish;
  /// The run cannot go on: say this line as FATAL and end with a code other than zero.
  std::function<void(const std::string&)> fail;
};

}  // namespace ring_gyro::nodes
