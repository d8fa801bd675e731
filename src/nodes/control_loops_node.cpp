#include "ring_gyro/nodes/control_loops_node.h"

#include <ros/console.h>

#include <utility>
#include <vector>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/ros/topics.h"

namespace ring_gyro {
namespace {

constexpr double kTick = 0.1;  // of the watch, wall time [s]
constexpr std::uint32_t kUnlimited = 0;

}  // namespace

ControlLoopsNode::ControlLoopsNode(ros::NodeHandle handle, ros::NodeHandle private_handle,
                                   const NodeConfiguration& configuration, NodeHost host)
    : handle_(std::move(handle)),
      parameters_(configuration.node),
      host_(std::move(host)),
      angular_gain_(configuration.loop.device.angular_gain),
      compensation_(configuration.loop.control.compensation),
      period_blocks_(configuration.loop.periodBlocks()),
      loops_(configuration.loop.control, configuration.loop.demodulation,
             configuration.loop.converter, configuration.loop.calibration),
      burst_blocks_(parameters_.lockstep ? static_cast<std::uint64_t>(parameters_.burst_blocks)
                                         : 1),
      command_(Output::advertise<ring_gyro_msgs::DriveCommand>(handle_, topics::kDriveCommand)),
      elements_(
          Output::advertise<ring_gyro_msgs::OrbitalElements>(handle_, topics::kOrbitalElements)),
      gains_(Output::advertise<ring_gyro_msgs::ControlGains>(handle_, topics::kControlGains)),
      imu_(Output::advertise<sensor_msgs::Imu>(handle_, topics::kImu)),
      departure_(handle_, parameters_, host_, {elements_, gains_}, [this] { leave(); }),
      diagnostics_(handle_, private_handle, private_handle.getNamespace(),
                   [this](auto& status) { report(status); }) {
  if (compensation_) {
    decision_subscriber_ = handle_.subscribe<ring_gyro_msgs::CompensationGains>(
        topics::kCompensationGains, kUnlimited,
        [this](const ring_gyro_msgs::CompensationGains::ConstPtr& message) {
          onDecision(*message);
        },
        ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
  }
  const auto required = static_cast<std::size_t>(parameters_.required_subscribers);
  gate_ = std::make_unique<StartGate>(
      handle_,
      std::vector<StartGate::Requirement>{{command_, 1}, {elements_, required}, {gains_, required}},
      [this] { start(); });
}

void ControlLoopsNode::start() {
  displacement_subscriber_ = handle_.subscribe<BlockMessage>(
      topics::kDisplacement, kUnlimited,
      [this](const BlockMessage::ConstPtr& message) { onDisplacement(message); },
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
  watch_timer_ = handle_.createWallTimer(ros::WallDuration(kTick),
                                         [this](const ros::WallTimerEvent&) { watchSilence(); });
}

void ControlLoopsNode::onDisplacement(const BlockMessage::ConstPtr& message) {
  if (mustWaitForDecision(*message)) {
    waiting_ = message;
    silent_ticks_ = 0;
    return;
  }
  process(*message);
}

bool ControlLoopsNode::mustWaitForDecision(const BlockMessage& message) const {
  if (!compensation_ || !parameters_.lockstep) return false;
  const std::uint64_t acts_in = message.sequence + 1;
  if (acts_in % period_blocks_ != 0 || acts_in < 2 * period_blocks_) return false;
  for (const CompensationDecision& decision : decisions_) {
    if (decision.session == message.session && decision.effective_sequence == acts_in) return false;
  }
  return true;
}

void ControlLoopsNode::onDecision(const ring_gyro_msgs::CompensationGains& message) {
  CompensationDecision decision;
  fromMessage(message, decision);
  if (guard_.counts().accepted > 0 && decision.session != block_.stamp.session) {
    ++foreign_decisions_;
    return;
  }
  if (guard_.counts().accepted > 0 && decision.effective_sequence <= block_.stamp.sequence + 1) {
    ++late_decisions_;
  }
  decisions_.push_back(decision);
  if (waiting_ != nullptr && !mustWaitForDecision(*waiting_)) {
    const BlockMessage::ConstPtr message_waited = std::move(waiting_);
    waiting_.reset();
    process(*message_waited);
  }
}

void ControlLoopsNode::applyDecisions(std::uint64_t acts_in) {
  while (!decisions_.empty() && decisions_.front().effective_sequence <= acts_in) {
    if (decisions_.front().session == block_.stamp.session) {
      loops_.setCompensation(decisions_.front().gains);
    } else {
      ++foreign_decisions_;  // latched from an earlier run
    }
    decisions_.pop_front();
  }
}

void ControlLoopsNode::process(const BlockMessage& message) {
  fromMessage(message, block_);
  if (!isUsable(guard_.check(block_.stamp))) return;
  applyDecisions(block_.stamp.sequence + 1);
  const LoopOutput& output = loops_.process(block_);
  if (!output.command.envelope.allFinite()) {
    host_.fail("the drive command that answers block " + std::to_string(block_.stamp.sequence) +
               " is not finite");
    return;
  }
  publish(output);
  status_ = output.elements.status;
  amplitude_ = output.elements.orbit.a;
  theta_rate_ = output.elements.theta_rate;
  if (status_.invalid_samples) ++invalid_blocks_;
  departure_.processed(block_.stamp.sequence);
}

void ControlLoopsNode::publish(const LoopOutput& output) {
  // The drive first: the plant can go on while the rest is being sent.
  const auto command = command_messages_.take();
  toMessage(output.command, block_.stamp, *command);
  command_.publish(command);
  if (elements_.subscribers() > 0) {
    const auto elements = elements_messages_.take();
    toMessage(output.elements, *elements);
    elements_burst_.push_back(elements);
  }
  if (gains_.subscribers() > 0) {
    const auto gains = gains_messages_.take();
    toMessage(output.gains, *gains);
    gains_burst_.push_back(gains);
  }
  const std::uint64_t blocks = block_.stamp.sequence + 1;
  if (blocks % burst_blocks_ == 0 || blocks % period_blocks_ == 0) sendBurst();
  if (imu_.subscribers() > 0) {
    const auto imu = imu_messages_.take();
    toMessage(output.elements, angular_gain_, parameters_.imu_frame, *imu);
    imu_.publish(imu);
  }
}

void ControlLoopsNode::sendBurst() {
  for (const auto& elements : elements_burst_) elements_.publish(elements);
  for (const auto& gains : gains_burst_) gains_.publish(gains);
  elements_burst_.clear();
  gains_burst_.clear();
}

void ControlLoopsNode::watchSilence() {
  if (waiting_ == nullptr) return;
  if (++silent_ticks_ * kTick < parameters_.lockstep_timeout) return;
  silent_ticks_ = 0;
  const std::uint64_t acts_in = waiting_->sequence + 1;
  const std::string who = decision_subscriber_.getNumPublishers() == 0
                              ? "nobody publishes " + decision_subscriber_.getTopic()
                              : "silent: the publisher of " + decision_subscriber_.getTopic() +
                                    " (the compensation injector), or the identifier before it";
  host_.fail("no compensation gains have come for block " + std::to_string(acts_in) +
             ", due from the estimate of block " + std::to_string(acts_in - period_blocks_ - 1) +
             ", for " + std::to_string(parameters_.lockstep_timeout) + " s: " + who);
}

void ControlLoopsNode::leave() {
  sendBurst();
  displacement_subscriber_.shutdown();
  decision_subscriber_.shutdown();
  watch_timer_.stop();
  ROS_INFO("last block %lu: a %.4f V, pattern at %.4f deg/s, %s",
           static_cast<unsigned long>(block_.stamp.sequence), amplitude_, toDegrees(theta_rate_),
           status_.locked() ? "locked" : "not locked");
}

void ControlLoopsNode::report(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  using diagnostic_msgs::DiagnosticStatus;
  const TimeGuard::Counts& counts = guard_.counts();
  if (counts.accepted == 0) {
    status.summary(DiagnosticStatus::OK, "waiting for displacement blocks");
  } else if (!status_.locked()) {
    status.summary(DiagnosticStatus::WARN, "not locked");
  } else if (status_.converter_saturated || status_.drive_saturated) {
    status.summary(DiagnosticStatus::WARN, "saturated");
  } else {
    status.summary(DiagnosticStatus::OK, "locked");
  }
  status.add("last sequence", block_.stamp.sequence);
  status.add("amplitude [V]", amplitude_);
  status.add("pattern rate [rad/s]", theta_rate_);
  status.add("amplitude locked", status_.amplitude_locked);
  status.add("quadrature locked", status_.quadrature_locked);
  status.add("phase locked", status_.phase_locked);
  status.add("blocks with invalid samples", invalid_blocks_);
  status.add("lost blocks", counts.lost);
  status.add("duplicate blocks", counts.duplicates);
  status.add("steps back", counts.steps_back);
  status.add("blocks with zero stamp", counts.zero_stamps);
  status.add("new sessions", counts.new_sessions);
  status.add("late compensation decisions", late_decisions_);
  status.add("compensation decisions of another session", foreign_decisions_);
}

}  // namespace ring_gyro
