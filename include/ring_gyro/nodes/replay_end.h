#pragma once

#include <ros/node_handle.h>
#include <ros/time.h>
#include <ros/wall_timer.h>

#include <cstdint>
#include <functional>

#include "ring_gyro/configuration/node_parameters.h"

namespace ring_gyro::nodes {

/// Finds from the bag itself when its replay is over, so that no end message is needed: all
/// messages of both topics have arrived; or /clock has reached the last of them and no more arrive;
/// or, without /clock, nothing has arrived for the configured time. docs/replay.md gives the rule
/// and its reasons.
class ReplayEnd {
 public:
  /// `parameters`: the bag, the part of it that is played, and how long to wait without /clock;
  /// `over`: called once, with the number of missing messages. Throws BagError.
  ReplayEnd(ros::NodeHandle& handle, const cvg::NodeParameters& parameters,
            std::function<void(std::uint64_t)> over);

  /// A message of one of the topics has been received and processed.
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
