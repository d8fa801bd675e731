#include "ring_gyro/nodes/calibration_node.h"

#include <ros/console.h>

#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "ring_gyro/calibration/calibration_report.h"
#include "ring_gyro/common/number_text.h"
#include "ring_gyro/configuration/configuration_writer.h"
#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/ros/message_checks.h"
#include "ring_gyro/ros/topics.h"
#include "ring_gyro/signals/calibration_command.h"

namespace ring_gyro::nodes {
namespace {

const bridge::NodeConfiguration& checked(const bridge::NodeConfiguration& configuration) {
  std::vector<std::string> faults;
  if (configuration.node.calibration_file.empty()) {
    faults.emplace_back(
        "node/calibration_file: missing; the calibration must be told which file to write");
  }
  if (configuration.loop.run.duration != 0.0) {
    faults.push_back("run/duration = " + cvg::textFromNumber(configuration.loop.run.duration) +
                     ": a calibration run lasts until it is complete; allowed: 0 [s]");
  }
  if (!configuration.loop.control.calibration_run) {
    faults.emplace_back(
        "control/calibration_run = false: the loops would not do what the calibration asks; "
        "allowed: true");
  }
  if (!faults.empty()) throw cvg::ConfigurationError(std::move(faults));
  return configuration;
}

}  // namespace

CalibrationNode::CalibrationNode(const ros::NodeHandle& handle,
                                 const ros::NodeHandle& private_handle,
                                 const bridge::NodeConfiguration& configuration, NodeHost host)
    : handle_(handle),
      parameters_(checked(configuration).node),
      device_(configuration.loop.device),
      host_(std::move(host)),
      procedure_(configuration.loop.device, configuration.loop.calibration_run,
                 configuration.loop.extended, configuration.loop.converter,
                 static_cast<std::int64_t>(configuration.loop.periodBlocks()),
                 configuration.loop.corrections),
      merge_([this](const cvg::OrbitalElements& elements, const cvg::ControlGains& gains) {
        process(elements, gains);
      }),
      block_duration_ns_(configuration.loop.converter.blockDurationNanoseconds()),
      file_(parameters_.calibration_file),
      output_(Output::advertise<ring_gyro::CalibrationCommand>(
          handle_, bridge::topics::kCalibrationCommand, true)),
      departure_(handle_, parameters_, {[this] { finish(); }, host_.fail}, {output_},
                 [this] { leave(); }),
      diagnostics_(handle_, private_handle, private_handle.getNamespace(),
                   [this](auto& status) { report(status); }) {
  const auto required = static_cast<std::size_t>(parameters_.required_subscribers);
  gate_ = std::make_unique<StartGate>(
      handle_, std::vector<StartGate::Requirement>{{output_, required}}, [this] { start(); });
}

void CalibrationNode::start() {
  const ros::TransportHints no_delay = ros::TransportHints().tcpNoDelay();
  elements_subscriber_ = handle_.subscribe<ring_gyro::OrbitalElements>(
      bridge::topics::kOrbitalElements, kInputQueue,
      [this](const ring_gyro::OrbitalElements::ConstPtr& message) {
        add(bridge::topics::kOrbitalElements, *message, elements_);
      },
      ros::VoidConstPtr(), no_delay);
  gains_subscriber_ = handle_.subscribe<ring_gyro::ControlGains>(
      bridge::topics::kControlGains, kInputQueue,
      [this](const ring_gyro::ControlGains::ConstPtr& message) {
        add(bridge::topics::kControlGains, *message, gains_);
      },
      ros::VoidConstPtr(), no_delay);
}

template <typename Message, typename Signal>
void CalibrationNode::add(const char* topic, const Message& message, Signal& signal) {
  if (const bridge::MessageFault fault = bridge::readChecked(message, signal)) {
    refusals_.add(topic, message.sequence, fault);
  }
  departure_.inSession(last_ ? last_->session : message.session);
  merge_.add(signal);
}

void CalibrationNode::process(const cvg::OrbitalElements& elements,
                              const cvg::ControlGains& gains) {
  if (last_ && last_->session != elements.stamp.session) {
    host_.fail("the plant has been started again during the calibration run");
    return;
  }
  last_ = elements.stamp;
  uses_.add(cvg::useOf(elements, gains, block_duration_ns_));
  if (const std::optional<cvg::CalibrationCommand> command = procedure_.process(elements, gains)) {
    if (!command_ || command->leg != command_->leg) {
      ROS_INFO("%s, %.0f s left", command->leg.c_str(), command->time_left);
    }
    command_ = command;
    publish(*command, elements.stamp);
    if (command->found && !command->finished) keep();
    if (!command->failure.empty()) fail(command->failure);
    if (command->finished) conclude();
  }
  departure_.processed(elements.stamp.sequence);
}

void CalibrationNode::publish(const cvg::CalibrationCommand& command, const cvg::BlockStamp& data) {
  const auto message = boost::make_shared<ring_gyro::CalibrationCommand>();
  bridge::toMessage(command, data, *message);
  output_.publish(message);
}

/// If the result cannot be written or read now, the rest of the run would be useless.
void CalibrationNode::keep() {
  try {
    file_.keep(cvg::calibrationYaml(procedure_.result(), device_));
  } catch (const std::exception& error) {
    fail(error.what());
    finish();
  }
}

void CalibrationNode::conclude() {
  if (written_ || !failure_.empty()) return;
  const cvg::CalibrationResult& result = procedure_.result();
  ROS_INFO("calibration\n%s", cvg::calibrationText(result).c_str());
  try {
    file_.finish(cvg::calibrationYaml(result, device_));
  } catch (const std::exception& error) {
    fail(error.what());
    return;
  }
  written_ = true;
  ROS_INFO("calibration in %s", parameters_.calibration_file.c_str());
}

/// Reports the failure at once, and again when the node exits.
void CalibrationNode::fail(const std::string& why) {
  if (!failure_.empty()) return;
  failure_ = why;
  ROS_ERROR("%s", why.c_str());
}

void CalibrationNode::leave() {
  elements_subscriber_.shutdown();
  gains_subscriber_.shutdown();
  merge_.flush();
  if (!written_) fail("the run ended before the calibration was complete");
}

void CalibrationNode::finish() {
  if (failure_.empty()) {
    host_.finish();
  } else {
    host_.fail("no calibration: " + failure_ +
               (file_.kept().empty() ? "" : "; what had been found is in " + file_.kept()));
  }
}

void CalibrationNode::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const cvg::PairMerge::Counts& counts = merge_.counts();
  const std::uint64_t lost = merge_.elementsCounts().lost + merge_.gainsCounts().lost +
                             counts.elements_alone + counts.gains_alone;
  const std::string none_used = use_.noneSinceLast(uses_);
  if (!failure_.empty()) {
    status.summary(DiagnosticStatus::ERROR, failure_);
  } else if (!none_used.empty()) {
    status.summary(DiagnosticStatus::WARN, none_used);
  } else if (!command_) {
    status.summary(DiagnosticStatus::OK, "waiting for orbital elements and control gains");
  } else if (lost > 0) {
    status.summary(DiagnosticStatus::WARN, command_->leg + ", blocks have been lost");
  } else {
    status.summary(DiagnosticStatus::OK, command_->leg);
  }
  status.add("blocks", counts.pairs);
  status.add("lost blocks", lost);
  status.add("blocks that wait for the other topic", merge_.waiting());
  status.add("partner silent for too long", counts.overdue);
  status.add("ends of other sessions", departure_.foreign());
  UseWatch::addTo(status, uses_);
  refusals_.addTo(status);
  if (!command_) return;
  status.add("time left [s]", command_->time_left);
  status.add("steering [rad/s]", command_->settings.virtual_rate);
  status.add("rate table [rad/s]", command_->settings.table_rate);
}

}  // namespace ring_gyro::nodes
