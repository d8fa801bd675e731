#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <ros/wall_timer.h>

#include <cstddef>
#include <functional>
#include <vector>

#include "ring_gyro/nodes/output.h"

namespace ring_gyro::nodes {

/// Holds a node back until its outputs have the required subscribers. Each node of the chain takes
/// no input before that, so nothing of a run is lost, whatever the order in which the nodes start.
///
/// Inputs that answer the outputs get two seconds more to be connected. After a restart of this
/// node an older subscriber may already receive its messages although its own answers do not arrive
/// yet.
class StartGate {
 public:
  struct Requirement {
    Output output;
    std::size_t subscribers = 0;
  };

  /// Calls `start` once, from the callback queue of `handle`. Reports from time to time what is
  /// missing.
  StartGate(ros::NodeHandle& handle, std::vector<Requirement> requirements,
            std::function<void()> start, std::vector<ros::Subscriber> answers = {});

 private:
  void check();

  std::vector<Requirement> requirements_;
  std::vector<ros::Subscriber> answers_;
  std::function<void()> start_;
  int checks_ = 0;
  int checks_for_answers_ = 0;
  ros::WallTimer timer_;
};

}  // namespace ring_gyro::nodes
