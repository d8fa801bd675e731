#pragma once

#include <ros/node_handle.h>
#include <ros/wall_timer.h>

#include <chrono>
#include <functional>
#include <vector>

#include "ring_gyro/configuration/node_parameters.h"
#include "ring_gyro/nodes/output.h"

namespace ring_gyro::nodes {

/// Keeps a lockstep run at the pace of those who read it: while a reader in another process is half
/// a queue behind, the next step waits, so that neither memory grows nor a message is lost. When a
/// step has been held for half the lockstep timeout the run goes on, and the reader loses what its
/// queue cannot hold, until it has caught up. In real time nobody waits.
class ReaderWait {
 public:
  /// `resume`: takes the step that was held.
  ReaderWait(ros::NodeHandle& handle, const cvg::NodeParameters& parameters,
             std::vector<Output> outputs, std::function<void()> resume);

  /// Whether the next step must be held; then `resume` will be called. Cheap.
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
