#pragma once

#include <ros/node_handle.h>
#include <ros/wall_timer.h>

#include <chrono>
#include <functional>
#include <vector>

#include "ring_gyro/configuration/node_parameters.h"
#include "ring_gyro/nodes/output.h"

namespace ring_gyro::nodes {

/// Limits the speed of a lockstep run to that of its readers: while a reader in another process is
/// half a queue behind, the next step waits, so that memory does not grow and no message is lost.
/// When a step has been held for half the lockstep timeout, the run continues, and the reader loses
/// messages that its queue cannot hold until it has caught up. In real time no step waits.
class ReaderWait {
 public:
  /// `resume`: makes the held step.
  ReaderWait(ros::NodeHandle& handle, const cvg::NodeParameters& parameters,
             std::vector<Output> outputs, std::function<void()> resume);

  /// Whether the next step must be held; if so, `resume` will be called later. Fast.
  bool mustHold() {
    if (!lockstep_ || !behind()) {
      given_up_ = false;
      return false;
    }
    return !given_up_ && hold();
  }
  bool holding() const { return holding_; }
  void stop() { timer_.stop(); }

 private:
  bool behind() const;
  bool hold();
  void tick();

  using WallClock = std::chrono::steady_clock;

  bool lockstep_;
  std::chrono::duration<double> patience_;
  std::vector<Output> outputs_;
  std::function<void()> resume_;
  bool holding_ = false;
  bool given_up_ = false;
  WallClock::time_point held_since_{};
  ros::WallTimer timer_;
};

}  // namespace ring_gyro::nodes
