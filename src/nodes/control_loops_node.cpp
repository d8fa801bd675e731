#include "ring_gyro/nodes/control_loops_node.h"

#include <ros/console.h>

#include <limits>
#include <utility>
#include <vector>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/ros/message_checks.h"
#include "ring_gyro/ros/topics.h"
#include "ring_gyro/signals/calibration_command.h"
#include "ring_gyro/signals/compensation_decision.h"

namespace ring_gyro::nodes {
namespace {

constexpr double kTick = 0.1;  // of the watchdog, wall time [s]

template <typename Counts>
void addDecisions(diagnostic_updater::DiagnosticStatusWrapper& status, const std::string& what,
                  const Counts& counts) {
  status.add("late " + what, counts.late);
  status.add(what + " of another session", counts.foreign);
  status.add(what + " too far ahead", counts.early);
}

}  // namespace

ControlLoopsNode::ControlLoopsNode(const ros::NodeHandle& handle,
                                   const ros::NodeHandle& private_handle,
                                   const bridge::NodeConfiguration& configuration, NodeHost host)
    : handle_(handle),
      parameters_(configuration.node),
      host_(std::move(host)),
      angular_gain_(configuration.loop.device.angular_gain),
      compensation_(configuration.loop.control.compensation),
      calibration_run_(configuration.loop.control.calibration_run),
      period_blocks_(configuration.loop.periodBlocks()),
      loops_(configuration.loop.device, configuration.loop.control, configuration.loop.demodulation,
             configuration.loop.converter, configuration.loop.corrections),
      compensation_decisions_(period_blocks_),
      calibration_commands_(period_blocks_),
      block_duration_ns_(configuration.loop.converter.blockDurationNanoseconds()),
      burst_blocks_(parameters_.lockstep ? static_cast<std::uint64_t>(parameters_.burst_blocks)
                                         : 1),
      command_(Output::advertise<ring_gyro::DriveCommand>(handle_, bridge::topics::kDriveCommand)),
      elements_(
          Output::advertise<ring_gyro::OrbitalElements>(handle_, bridge::topics::kOrbitalElements)),
      gains_(Output::advertise<ring_gyro::ControlGains>(handle_, bridge::topics::kControlGains)),
      imu_(Output::advertise<sensor_msgs::Imu>(handle_, bridge::topics::kImu)),
      reader_wait_(handle_, parameters_, {elements_, gains_, imu_}, [this] { processWaiting(); }),
      departure_(handle_, parameters_, host_, {elements_, gains_}, [this] { leave(); }),
      diagnostics_(handle_, private_handle, private_handle.getNamespace(),
                   [this](auto& status) { report(status); }) {
  if (compensation_) {
    decision_subscriber_ = subscribeDecisions<ring_gyro::CompensationGains>(
        bridge::topics::kCompensationGains, compensation_decisions_);
  }
  if (calibration_run_) {
    decision_subscriber_ = subscribeDecisions<ring_gyro::CalibrationCommand>(
        bridge::topics::kCalibrationCommand, calibration_commands_);
  }
  const auto required = static_cast<std::size_t>(parameters_.required_subscribers);
  gate_ = std::make_unique<StartGate>(
      handle_,
      std::vector<StartGate::Requirement>{
          {command_, parameters_.blockListeners()}, {elements_, required}, {gains_, required}},
      [this] { start(); });
}

template <typename Message, typename Decision>
ros::Subscriber ControlLoopsNode::subscribeDecisions(const char* topic,
                                                     cvg::DecisionQueue<Decision>& decisions) {
  return handle_.subscribe<Message>(
      topic, kInputQueue,
      [this, topic, &decisions](const boost::shared_ptr<const Message>& message) {
        if (const bridge::MessageFault fault = bridge::faultOf(*message)) {
          refusals_.add(topic, message->data_sequence, fault);
          return;
        }
        Decision decision;
        bridge::fromMessage(*message, decision);
        decisions.add(std::move(decision));
        processWaiting();
      },
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
}

void ControlLoopsNode::start() {
  displacement_subscriber_ = handle_.subscribe<BlockMessage>(
      bridge::topics::kDisplacement, kInputQueue,
      [this](const BlockMessage::ConstPtr& message) { onDisplacement(message); },
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
  watch_timer_ = handle_.createWallTimer(ros::WallDuration(kTick),
                                         [this](const ros::WallTimerEvent&) { watchSilence(); });
}

void ControlLoopsNode::onDisplacement(const BlockMessage::ConstPtr& message) {
  // Check this first: a duplicate neither waits for a decision nor replaces the waiting block.
  if (!isNew(*message)) return;
  departure_.inSession(message->session);
  if (waiting_ != nullptr) {
    refusals_.add(bridge::topics::kDisplacement, "overtaken by a later block",
                  "block " + std::to_string(waiting_->sequence) + ": block " +
                      std::to_string(message->sequence) + " came while it waited");
    waiting_.reset();
  }
  if (mustWait(*message)) {
    waiting_ = message;
    silent_ticks_ = 0;
    return;
  }
  process(*message);
}

/// Whether the block must be answered, judged by its stamp.
bool ControlLoopsNode::isNew(const BlockMessage& message) {
  const cvg::BlockStamp stamp{message.session, message.sequence,
                              bridge::nanosecondsFromTime(message.header.stamp),
                              static_cast<std::int64_t>(message.duration)};
  const auto refuse = [&](const char* reason, const std::string& particulars) {
    refusals_.add(bridge::topics::kDisplacement, reason,
                  "block " + std::to_string(message.sequence) + " of session " +
                      std::to_string(message.session) + ": " + particulars);
    return false;
  };
  const cvg::StampOrder order = guard_.order(stamp);
  if (order == cvg::StampOrder::kStepBack && parameters_.lockstep) {
    // The plant continues with the answer that it has.
    return refuse("of a block that was answered", "a later one has come before");
  }
  if (order == cvg::StampOrder::kNewSession && message.sequence > 0 &&
      message.session != unconfirmed_session_) {
    unconfirmed_session_ = message.session;
    return refuse("of another session",
                  "neither the first block of a run nor one that follows "
                  "another of its session");
  }
  guard_.check(stamp);
  if (order == cvg::StampOrder::kZero) {
    return refuse("with a stamp of zero", "have its publisher send the end of the block");
  }
  if (order == cvg::StampOrder::kLeftSession) {
    return refuse("of a session that was left", "stop the plant of the other run");
  }
  if (cvg::isUsable(order)) unconfirmed_session_.reset();
  return cvg::isUsable(order);
}

bool ControlLoopsNode::mustWait(const BlockMessage& message) {
  return mustWaitForDecision(message) || reader_wait_.mustHold();
}

bool ControlLoopsNode::mustWaitForDecision(const BlockMessage& message) const {
  if (!parameters_.lockstep) return false;
  const std::uint64_t acts_in = message.sequence + 1;
  return (compensation_ && compensation_decisions_.mustWaitFor(message.session, acts_in)) ||
         (calibration_run_ && calibration_commands_.mustWaitFor(message.session, acts_in));
}

void ControlLoopsNode::processWaiting() {
  if (waiting_ == nullptr || mustWait(*waiting_)) return;
  const BlockMessage::ConstPtr message = std::move(waiting_);
  waiting_.reset();
  process(*message);
}

void ControlLoopsNode::applyDecisions() {
  const std::uint32_t session = block_.stamp.session;
  const std::uint64_t acts_in = block_.stamp.sequence + 1;
  compensation_decisions_.applyDue(session, acts_in,
                                   [this](const cvg::CompensationDecision& decision) {
                                     loops_.setCompensation(decision.gains);
                                   });
  calibration_commands_.applyDue(session, acts_in, [this](const cvg::CalibrationCommand& command) {
    loops_.setSettings(command.settings);
  });
}

void ControlLoopsNode::process(const BlockMessage& message) {
  read(message);
  applyDecisions();
  const cvg::LoopOutput& output = loops_.process(block_);
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

/// A block with impossible numbers is passed without samples and reference: the loops then coast
/// and continue from their own last command.
void ControlLoopsNode::read(const BlockMessage& message) {
  bridge::fromMessage(message, block_);
  const bridge::MessageFault fault = bridge::faultOf(message);
  if (!fault) return;
  refusals_.add(bridge::topics::kDisplacement, message.sequence, fault);
  block_.x.clear();
  block_.y.clear();
  block_.saturated_samples = 0;
  block_.clipped_drive_samples = 0;
  block_.stamp.duration_ns = block_duration_ns_;
  block_.reference_phase = block_.reference_frequency = std::numeric_limits<double>::quiet_NaN();
}

void ControlLoopsNode::publish(const cvg::LoopOutput& output) {
  // The drive first, so that the plant can continue while the other messages are sent.
  const auto command = command_messages_.take();
  bridge::toMessage(output.command, block_.stamp, *command);
  command_.publish(command);
  if (elements_.subscribers() > 0) {
    const auto elements = elements_messages_.take();
    bridge::toMessage(output.elements, *elements);
    elements_burst_.push_back(elements);
  }
  if (gains_.subscribers() > 0) {
    const auto gains = gains_messages_.take();
    bridge::toMessage(output.gains, *gains);
    gains_burst_.push_back(gains);
  }
  const std::uint64_t blocks = block_.stamp.sequence + 1;
  if (blocks % burst_blocks_ == 0 || blocks % period_blocks_ == 0) sendBurst();
  if (imu_.subscribers() > 0) {
    const auto imu = imu_messages_.take();
    bridge::toMessage(output.elements, angular_gain_, parameters_.imu_frame, *imu);
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
  if (waiting_ == nullptr || !mustWaitForDecision(*waiting_)) return;
  if (++silent_ticks_ * kTick < parameters_.lockstep_timeout) return;
  silent_ticks_ = 0;
  const std::uint64_t acts_in = waiting_->sequence + 1;
  const std::string topic = decision_subscriber_.getTopic();
  const std::string publisher = calibration_run_
                                    ? " (the calibration)"
                                    : " (the compensation injector), or the identifier before it";
  const std::string who = decision_subscriber_.getNumPublishers() == 0
                              ? "nobody publishes " + topic
                              : "silent: the publisher of " + topic + publisher;
  host_.fail("no " + std::string(calibration_run_ ? "calibration command" : "compensation gains") +
             " for block " + std::to_string(acts_in) + ", due from the data up to block " +
             std::to_string(acts_in - period_blocks_ - 1) + ", for " +
             std::to_string(parameters_.lockstep_timeout) + " s: " + who);
}

void ControlLoopsNode::leave() {
  sendBurst();
  displacement_subscriber_.shutdown();
  decision_subscriber_.shutdown();
  watch_timer_.stop();
  reader_wait_.stop();
  ROS_INFO("last block %lu: a %.4f V, pattern at %.4f deg/s, %s",
           static_cast<unsigned long>(block_.stamp.sequence), amplitude_,
           cvg::toDegrees(theta_rate_), status_.locked() ? "locked" : "not locked");
}

void ControlLoopsNode::report(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  using diagnostic_msgs::DiagnosticStatus;
  const cvg::TimeGuard::Counts& counts = guard_.counts();
  if (counts.accepted == 0) {
    status.summary(DiagnosticStatus::OK, "waiting for displacement blocks");
  } else if (!status_.locked()) {
    status.summary(DiagnosticStatus::WARN, "not locked");
  } else if (refusals_.total() > 0) {
    status.summary(DiagnosticStatus::WARN, "locked, messages have been refused");
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
  status.add("blocks of a session that was left", counts.left_sessions);
  status.add("blocks that slow readers lost",
             elements_.overflows() + gains_.overflows() + imu_.overflows());
  status.add("ends of other sessions", departure_.foreign());
  refusals_.addTo(status);
  if (compensation_)
    addDecisions(status, "compensation decisions", compensation_decisions_.counts());
  if (calibration_run_)
    addDecisions(status, "calibration commands", calibration_commands_.counts());
}

}  // namespace ring_gyro::nodes
