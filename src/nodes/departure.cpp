#include "ring_gyro/nodes/departure.h"

#include <ros/console.h>

#include <cmath>
#include <string>
#include <utility>

#include "ring_gyro/ros/topics.h"

namespace ring_gyro::nodes {
namespace {

constexpr double kTick = 0.05;  // wall time [s]
constexpr int kIdleTicks = 40;  // without a new block, after which missing blocks are lost
constexpr int kFlushTicks = 4;  // for messages that are still in the sockets

}  // namespace

Departure::Departure(ros::NodeHandle& handle, const cvg::NodeParameters& parameters, NodeHost host,
                     std::vector<Output> outputs, std::function<void()> leave)
    : allowed_subscribers_(static_cast<std::size_t>(parameters.recorders)),
      // Less than the plant waits, so that the plant exits last.
      ticks_allowed_(static_cast<int>(std::ceil(0.5 * parameters.exit_timeout / kTick))),
      host_(std::move(host)),
      outputs_(std::move(outputs)),
      leave_(std::move(leave)) {
  subscriber_ = handle.subscribe<ring_gyro::EndOfRun>(
      bridge::topics::kEndOfRun, 1,
      [this](const ring_gyro::EndOfRun::ConstPtr& message) { onEndOfRun(*message); });
  timer_ = handle.createWallTimer(
      ros::WallDuration(kTick), [this](const ros::WallTimerEvent&) { tick(); }, false, false);
}

void Departure::onEndOfRun(const ring_gyro::EndOfRun& message) {
  if (leaving_) return;
  if (!in_session_) {
    early_ = message;
    ROS_INFO("session %u ended with block %lu before any of its data came: waiting for data",
             message.session, static_cast<unsigned long>(message.last_sequence));
  } else if (message.session == session_) {
    announce(message);
  } else {
    leaveOut(message);
  }
}

void Departure::enterSession(std::uint32_t session) {
  in_session_ = true;
  session_ = session;
  any_processed_ = false;
  last_processed_ = processed_at_tick_ = 0;
  if (announced_ && !leaving_) {
    ROS_WARN("session %u began before all of the one that had ended came: going on with it",
             session);
    timer_.stop();
  }
  announced_ = false;
  if (!early_) return;
  const ring_gyro::EndOfRun early = *early_;
  early_.reset();
  if (early.session == session) {
    announce(early);
  } else {
    leaveOut(early);
  }
}

void Departure::announce(const ring_gyro::EndOfRun& message) {
  announced_ = true;
  last_sequence_ = message.last_sequence;
  idle_ticks_ = 0;
  timer_.start();
  leaveIfDone();
}

void Departure::leaveOut(const ring_gyro::EndOfRun& message) {
  ++foreign_;
  ROS_WARN(
      "refused %s: session %u has ended, the data that come are of session %u; stop the "
      "plant of the other run",
      bridge::topics::kEndOfRun, message.session, session_);
}

void Departure::leaveIfDone() {
  if (any_processed_ && last_processed_ >= last_sequence_) leave();
}

void Departure::leaveNow() {
  if (leaving_) return;
  timer_.start();
  leave();
}

void Departure::leave() {
  leaving_ = true;
  leave_();
}

void Departure::tick() {
  if (!leaving_) {
    idle_ticks_ = last_processed_ == processed_at_tick_ ? idle_ticks_ + 1 : 0;
    processed_at_tick_ = last_processed_;
    if (idle_ticks_ < kIdleTicks) return;
    ROS_WARN("the run ended with block %lu, the last that came was %lu: the rest has been lost",
             static_cast<unsigned long>(last_sequence_),
             static_cast<unsigned long>(last_processed_));
    leave();
    return;
  }
  ++leaving_ticks_;
  std::string listeners;
  for (const Output& output : outputs_) {
    if (output.subscribers() > allowed_subscribers_) {
      listeners += " " + output.topic() + ": " + output.listeners();
    }
  }
  if (!listeners.empty() && leaving_ticks_ < ticks_allowed_) return;
  if (listeners.empty() && leaving_ticks_ < kFlushTicks) return;
  if (!listeners.empty()) ROS_WARN("leaving although there are listeners;%s", listeners.c_str());
  timer_.stop();
  subscriber_.shutdown();
  host_.finish();
}

}  // namespace ring_gyro::nodes
