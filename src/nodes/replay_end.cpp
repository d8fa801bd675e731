#include "ring_gyro/nodes/replay_end.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ring_gyro/ros/loop_bag.h"

namespace ring_gyro::nodes {
namespace {

constexpr double kTick = 0.05;        // wall time [s]
constexpr int kIdleTicks = 40;        // after the end of the bag; then missing messages are lost
constexpr double kClockSlack = 0.05;  // /clock may stop this much before the last message [s]

/// Simulated time; zero without /clock.
ros::Time clock() { return ros::Time::isSimTime() ? ros::Time::now() : ros::Time(); }

}  // namespace

ReplayEnd::ReplayEnd(ros::NodeHandle& handle, const cvg::NodeParameters& parameters,
                     std::function<void(std::uint64_t)> over)
    : ticks_without_clock_(static_cast<int>(std::ceil(parameters.replay_timeout / kTick))),
      over_(std::move(over)) {
  const bridge::LoopBag bag(parameters.replay);
  if (!bag.hasIndex()) {
    throw bridge::BagError(parameters.replay + ": " + bag.damage().front() +
                           "; rosbag play needs the index, identify does not");
  }
  const ros::Time from = bag.begin() + ros::Duration(parameters.replay_start);
  const ros::Time to = parameters.replay_duration > 0.0
                           ? from + ros::Duration(parameters.replay_duration)
                           : ros::TIME_MAX;
  const bridge::LoopBag::Content content = bag.content(from, to);
  if (content.messages == 0) {
    throw bridge::BagError(parameters.replay +
                           ": no message in the span that is replayed; give another "
                           "start or duration");
  }
  expected_ = content.messages;
  last_ = content.last;
  timer_ = handle.createWallTimer(ros::WallDuration(kTick),
                                  [this](const ros::WallTimerEvent&) { tick(); });
}

void ReplayEnd::received() {
  if (++received_ == expected_) end();
}

void ReplayEnd::tick() {
  idle_ticks_ = received_ == received_at_tick_ ? idle_ticks_ + 1 : 0;
  received_at_tick_ = received_;
  const ros::Time now = clock();
  if (now.isZero()) {
    if (received_ > 0 && idle_ticks_ >= ticks_without_clock_) end();
  } else if (now + ros::Duration(kClockSlack) >= last_ && idle_ticks_ >= kIdleTicks) {
    end();
  }
}

void ReplayEnd::end() {
  if (ended_) return;
  ended_ = true;
  timer_.stop();
  over_(expected_ - std::min(expected_, received_));
}

}  // namespace ring_gyro::nodes
