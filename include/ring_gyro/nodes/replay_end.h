#pragma once

#include <ros/node_handle.h>
#include <ros/time.h>
#include <ros/wall_timer.h>

#include <cstdint>
#include <functional>

#include "ring_gyro/configuration/node_parameters.h"

namespace ring_gyro::nodes {

/// Knows from the bag itself when its replay is over, as no message has to say so: all messages of
/// both topics have come; or /clock has reached the last of them and nothing comes any more; or,
/// without a /clock, nothing has come for the time that the node is told to wait. The rule and its
/// reasons are in docs/replay.md.
class ReplayEnd {
 public:
  /// `parameters`: the bag, the part of it that is played, and how long to wait without a /clock;
  /// `over`: called once, with the messages that never came. Throws BagError.
  ReplayEnd(ros::NodeHandle& handle, const cvg::NodeParameters& parameters,
            std::function<void(std::uint64_t)> over);

  /// A message of either topic has come and has been dealt with.
  void received();

 private:
  void tick();
  void end();

  std::uint64_t expected_ = 0;
  std::uint64_t received_ = 0;
  std::uint64_t received_at_tick_ = 0;
  ros::Time last_;
  int ticks_without_clock_;
  int idle_ticks_ = 0;
  bool ended_ = false;
  std::function<void(std::uint64_t)> over_;
  ros::WallTimer timer_;
};

}  // namespace ring_gyro::nodes
