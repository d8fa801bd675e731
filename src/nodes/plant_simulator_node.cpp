#include "ring_gyro/nodes/plant_simulator_node.h"

#include <ros/console.h>
#include <ros/names.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <numeric>
#include <sstream>
#include <string>
#include <utility>

#include "ring_gyro/nodes/death.h"
#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/ros/message_checks.h"
#include "ring_gyro/ros/topics.h"

namespace ring_gyro::nodes {
namespace {

constexpr double kTick = 0.1;  // of the watchdog, wall time [s]
constexpr int kTicksPerProgress = 20;
constexpr int kTicksPerLook = 10;  // between checks for dead nodes
constexpr int kFlushTicks = 5;     // at the end, for messages that are still in the sockets

double seconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

/// Sums are enough: a value that is not finite makes its sum not finite.
bool isFinite(const cvg::DisplacementBlock& block) {
  return std::isfinite(std::accumulate(block.x.begin(), block.x.end(), 0.0)) &&
         std::isfinite(std::accumulate(block.y.begin(), block.y.end(), 0.0));
}

}  // namespace

PlantSimulatorNode::PlantSimulatorNode(const ros::NodeHandle& handle,
                                       const ros::NodeHandle& private_handle,
                                       const bridge::NodeConfiguration& configuration,
                                       NodeHost host)
    : handle_(handle),
      parameters_(configuration.node),
      host_(std::move(host)),
      duration_(configuration.loop.run.duration),
      blocks_(configuration.loop.run.blocks(configuration.loop.converter)),
      burst_blocks_(parameters_.lockstep ? static_cast<std::uint64_t>(parameters_.burst_blocks)
                                         : 1),
      block_ns_(configuration.loop.converter.blockDurationNanoseconds()),
      start_ns_(configuration.loop.run.startNanoseconds()),
      plant_(configuration.loop.plant, configuration.loop.converter,
             static_cast<std::uint64_t>(configuration.loop.run.seed),
             configuration.loop.run.sessionIdentifier(), start_ns_),
      displacement_(
          Output::advertise<ring_gyro::DisplacementBlock>(handle_, bridge::topics::kDisplacement)),
      truth_(Output::advertise<ring_gyro::PlantTruth>(handle_, bridge::topics::kPlantTruth)),
      end_of_run_(Output::advertise<ring_gyro::EndOfRun>(handle_, bridge::topics::kEndOfRun, true)),
      reader_wait_(handle_, parameters_, {displacement_, truth_}, [this] { goOn(); }),
      clock_(handle_.advertise<rosgraph_msgs::Clock>("/clock", 10)),
      diagnostics_(handle_, private_handle, private_handle.getNamespace(),
                   [this](auto& status) { report(status); }) {
  // If this node is started again with the same parameters, its blocks must have another session
  // than those of this run.
  private_handle.setParam("run/session",
                          static_cast<int>(configuration.loop.run.followingSession()));
  drive_subscriber_ = handle_.subscribe<ring_gyro::DriveCommand>(
      bridge::topics::kDriveCommand, kInputQueue,
      [this](const ring_gyro::DriveCommand::ConstPtr& message) { onDriveCommand(*message); },
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
  const auto required = static_cast<std::size_t>(parameters_.required_subscribers);
  gate_ = std::make_unique<StartGate>(
      handle_,
      std::vector<StartGate::Requirement>{{displacement_, parameters_.blockListeners()},
                                          {truth_, required}},
      [this] { start(); }, std::vector<ros::Subscriber>{drive_subscriber_});
}

void PlantSimulatorNode::start() {
  started_at_ = reported_at_ = WallClock::now();
  clock_at_ = started_at_ - std::chrono::seconds(1);
  started_ = true;
  watch_timer_ = handle_.createWallTimer(ros::WallDuration(kTick),
                                         [this](const ros::WallTimerEvent&) { watch(); });
  if (!parameters_.lockstep) {
    block_timer_ =
        handle_.createWallTimer(ros::WallDuration(1e-9 * static_cast<double>(block_ns_)),
                                [this](const ros::WallTimerEvent&) { onRealTimeTick(); });
  }
  publish(plant_.start());
}

/// Whether the command is for this plant, and for a block that has no answer yet.
bool PlantSimulatorNode::accepts(const ring_gyro::DriveCommand& message) {
  const auto refuse = [&](const char* reason, const std::string& particulars) {
    refusals_.add(
        bridge::topics::kDriveCommand, reason,
        "answer to block " + std::to_string(message.answers_sequence) + ": " + particulars);
    return false;
  };
  if (!started_ || ended_) return refuse("outside of the run", "the run is not under way");
  if (message.session != last_.session) {
    return refuse("of another session", "of session " + std::to_string(message.session) +
                                            ", this is session " + std::to_string(last_.session) +
                                            "; stop the loops of the other run");
  }
  const bool answered = any_command_ && message.answers_sequence <= command_.answers_sequence;
  if (answered || (parameters_.lockstep && message.answers_sequence < last_.sequence)) {
    return refuse("to a block that was answered", "it was answered before");
  }
  if (message.answers_sequence > last_.sequence) {
    return refuse("to a block that is still to come",
                  "the last block is " + std::to_string(last_.sequence));
  }
  return true;
}

void PlantSimulatorNode::onDriveCommand(const ring_gyro::DriveCommand& message) {
  if (!accepts(message)) return;
  const bridge::MessageFault fault = bridge::faultOf(message);
  if (fault) refusals_.add(bridge::topics::kDriveCommand, message.answers_sequence, fault);
  if (parameters_.lockstep) {
    silent_ticks_ = 0;
    // It still counts as an answer: a fault in one block need not end a run.
    coasts_ = static_cast<bool>(fault);
    if (fault) {
      command_.answers_sequence = message.answers_sequence;
    } else {
      bridge::fromMessage(message, command_);
    }
    any_command_ = true;
    if (!reader_wait_.mustHold()) goOn();
    return;
  }
  if (fault) return;
  bridge::fromMessage(message, command_);
  any_command_ = commanded_ = true;
  // A machine that is behind real time catches up as fast as the answers arrive.
  if (behindRealTime() > 0.0) onRealTimeTick();
}

/// Lockstep: the last block has been answered.
void PlantSimulatorNode::goOn() {
  silent_ticks_ = 0;
  if (ended_) return;
  if (lastBlockDone()) {
    endRun();
  } else if (coasts_) {
    ++coasted_;
    publish(plant_.coast());
  } else {
    step();
  }
}

bool PlantSimulatorNode::lastBlockDone() const {
  return command_.end_of_run || (blocks_ != 0 && last_.sequence + 1 >= blocks_);
}

double PlantSimulatorNode::behindRealTime() const {
  const double next = 1e-9 * static_cast<double>(last_.end_ns + block_ns_ - start_ns_);
  return seconds(WallClock::now() - started_at_) - next;
}

void PlantSimulatorNode::step() {
  try {
    plant_.setRotationRate(command_.table_rate);
    publish(plant_.step(command_));
  } catch (const std::domain_error& error) {
    host_.fail(error.what());
  }
}

void PlantSimulatorNode::onRealTimeTick() {
  if (ended_) return;
  if (lastBlockDone()) {
    endRun();
    return;
  }
  if (!commanded_) {
    ++coasted_;
    publish(plant_.coast());
    return;
  }
  commanded_ = false;
  const std::uint64_t late_by = last_.sequence - command_.answers_sequence;
  if (late_by > 0) {
    // Continue the phase of the NCO from the block that the command was meant for.
    ++late_;
    const double late_time = 1e-9 * static_cast<double>(block_ns_) * static_cast<double>(late_by);
    command_.reference_phase =
        cvg::wrapToPi(command_.reference_phase + command_.reference_frequency * late_time);
  }
  step();
}

void PlantSimulatorNode::publish(const cvg::DisplacementBlock& block) {
  last_ = block.stamp;
  if (!isFinite(block)) {
    host_.fail("the displacement of block " + std::to_string(last_.sequence) + " is not finite");
    return;
  }
  publishClock(last_);
  const auto message = displacement_messages_.take();
  bridge::toMessage(block, *message);
  displacement_.publish(message);
  if (truth_.subscribers() > 0) {
    const auto truth = truth_messages_.take();
    bridge::toMessage(plant_.truth(), *truth);
    truth_burst_.push_back(truth);
  }
  if ((last_.sequence + 1) % burst_blocks_ == 0) sendTruths();
}

void PlantSimulatorNode::sendTruths() {
  for (const auto& truth : truth_burst_) truth_.publish(truth);
  truth_burst_.clear();
}

void PlantSimulatorNode::publishClock(const cvg::BlockStamp& stamp) {
  const WallClock::time_point now = WallClock::now();
  if (seconds(now - clock_at_) * parameters_.clock_rate < 1.0) return;
  clock_at_ = now;
  rosgraph_msgs::Clock clock;
  clock.clock = bridge::timeFromNanoseconds(stamp.end_ns);
  clock_.publish(clock);
}

void PlantSimulatorNode::endRun() {
  ended_ = true;
  block_timer_.stop();
  drive_subscriber_.shutdown();
  sendTruths();
  const auto message = boost::make_shared<ring_gyro::EndOfRun>();
  message->header.stamp = bridge::timeFromNanoseconds(last_.end_ns);
  message->session = last_.session;
  message->last_sequence = last_.sequence;
  end_of_run_.publish(message);
  const double wall = seconds(WallClock::now() - started_at_);
  ROS_INFO("end of the run: %.3f s simulated in %.2f s, %.1f times real time", simulatedTime(),
           wall, simulatedTime() / wall);
}

double PlantSimulatorNode::simulatedTime() const {
  return started_ ? 1e-9 * static_cast<double>(last_.end_ns - start_ns_) : 0.0;
}

void PlantSimulatorNode::watch() {
  if (ended_) {
    waitForListeners();
    return;
  }
  if (parameters_.lockstep) watchSilence();
  if (++ticks_ % kTicksPerLook == 0) watchNodes();
  if (ticks_ % kTicksPerProgress == 0) reportProgress();
}

void PlantSimulatorNode::watchSilence() {
  if (reader_wait_.holding()) silent_ticks_ = 0;
  // Counted in ticks, not read from a clock, because the machine itself may have been suspended.
  if (++silent_ticks_ * kTick < parameters_.lockstep_timeout) return;
  silent_ticks_ = 0;
  host_.fail("no drive command has answered block " + std::to_string(last_.sequence) + " for " +
             std::to_string(parameters_.lockstep_timeout) + " s: silent: " +
             displacement_.listeners() + " (subscribed to " + displacement_.topic() + ")");
}

void PlantSimulatorNode::watchNodes() {
  std::istringstream names(parameters_.watched);
  for (std::string name; names >> name;) {
    const std::string node = ros::names::resolve(handle_.getNamespace(), name);
    if (end_of_run_.hasListener(node) || !hasDied(node)) continue;
    host_.fail(node + " has died: the run is cut after block " + std::to_string(last_.sequence));
    return;
  }
}

void PlantSimulatorNode::reportProgress() {
  const WallClock::time_point now = WallClock::now();
  const double time = simulatedTime();
  const double speed = (time - reported_time_) / seconds(now - reported_at_);
  reported_at_ = now;
  reported_time_ = time;
  if (duration_ > 0.0) {
    ROS_INFO("simulated %.1f of %.1f s, %.1f times real time", time, duration_, speed);
  } else {
    ROS_INFO("simulated %.1f s, %.1f times real time", time, speed);
  }
}

void PlantSimulatorNode::waitForListeners() {
  ++ending_ticks_;
  const auto allowed = static_cast<std::size_t>(parameters_.recorders);
  const bool listened_to = end_of_run_.subscribers() > allowed;
  if (listened_to && ending_ticks_ * kTick < parameters_.exit_timeout) return;
  if (!listened_to && ending_ticks_ < kFlushTicks) return;
  if (listened_to) {
    ROS_WARN("leaving although %s still listen to %s", end_of_run_.listeners().c_str(),
             end_of_run_.topic().c_str());
  }
  watch_timer_.stop();
  host_.finish();
}

void PlantSimulatorNode::report(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  using diagnostic_msgs::DiagnosticStatus;
  if (!started_) {
    status.summary(DiagnosticStatus::OK, "waiting for subscribers");
  } else if (ended_) {
    status.summary(DiagnosticStatus::OK, "run ended");
  } else if (late_ + coasted_ > 0) {
    status.summary(DiagnosticStatus::WARN, "running, some drive commands were late or missing");
  } else {
    status.summary(DiagnosticStatus::OK, "running");
  }
  status.add("simulated time [s]", simulatedTime());
  status.add("last sequence", last_.sequence);
  status.add("blocks without a new drive command", coasted_);
  status.add("late drive commands", late_);
  status.add("blocks that slow readers lost", displacement_.overflows() + truth_.overflows());
  status.add("rejected drive commands", refusals_.total());
  refusals_.addTo(status);
  if (started_ && !ended_ && !parameters_.lockstep) {
    status.add("behind real time [s]", behindRealTime());
  }
}

}  // namespace ring_gyro::nodes
