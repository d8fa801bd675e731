#include "ring_gyro/nodes/reader_wait.h"

#include <ros/console.h>

#include <algorithm>
#include <string>
#include <utility>

namespace ring_gyro::nodes {
namespace {

constexpr double kTick = 0.001;  // between checks while a step is held, wall time [s]

}  // namespace

ReaderWait::ReaderWait(ros::NodeHandle& handle, const cvg::NodeParameters& parameters,
                       std::vector<Output> outputs, std::function<void()> resume)
    : lockstep_(parameters.lockstep),
      // Less than the time that the other node of the loop waits for this one.
      patience_(0.5 * parameters.lockstep_timeout),
      outputs_(std::move(outputs)),
      resume_(std::move(resume)) {
  timer_ = handle.createWallTimer(
      ros::WallDuration(kTick), [this](const ros::WallTimerEvent&) { tick(); }, false, false);
}

bool ReaderWait::behind() const {
  return std::any_of(outputs_.begin(), outputs_.end(),
                     [](const Output& output) { return output.waiting() >= kOutputQueue / 2; });
}

bool ReaderWait::hold() {
  if (holding_) return true;
  holding_ = true;
  held_since_ = WallClock::now();
  timer_.start();
  return true;
}

void ReaderWait::tick() {
  if (!holding_) return;
  if (behind()) {
    if (WallClock::now() - held_since_ < patience_) return;
    given_up_ = true;
    std::string readers;
    for (const Output& output : outputs_) {
      if (output.waiting() >= kOutputQueue / 2) {
        readers += "; " + output.topic() + ": " + output.listeners();
      }
    }
    ROS_WARN(
        "the run has waited %.1f s for a reader: going on, it will lose blocks until it has caught "
        "up%s",
        patience_.count(), readers.c_str());
  }
  holding_ = false;
  timer_.stop();
  resume_();
}

}  // namespace ring_gyro::nodes
