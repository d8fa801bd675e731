#include "ring_gyro/nodes/ekf_identifier_node.h"

#include <ros/console.h>

#include <cmath>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/ros/topics.h"

namespace ring_gyro::nodes {

EkfIdentifierNode::EkfIdentifierNode(const ros::NodeHandle& handle,
                                     const ros::NodeHandle& private_handle,
                                     const bridge::NodeConfiguration& configuration, NodeHost host)
    : handle_(handle),
      host_(std::move(host)),
      configuration_(configuration.loop),
      parameters_(configuration.node),
      report_file_(parameters_.report),
      identifier_(configuration.loop,
                  [this](const cvg::ParameterEstimate& estimate) { take(estimate); }),
      estimate_output_(Output::advertise<ring_gyro::ParameterEstimate>(
          handle_, bridge::topics::kParameterEstimate, true)),
      departure_(handle_, configuration.node, host_, {estimate_output_}, [this] { leave(); }),
      diagnostics_(handle_, private_handle, private_handle.getNamespace(),
                   [this](auto& status) { report(status); }) {
  if (!parameters_.replay.empty()) {
    replay_end_ =
        std::make_unique<ReplayEnd>(handle_, parameters_, [this](std::uint64_t not_delivered) {
          not_delivered_ = not_delivered;
          departure_.leaveNow();
        });
  }
  const auto required = static_cast<std::size_t>(configuration.node.required_subscribers);
  gate_ = std::make_unique<StartGate>(
      handle_, std::vector<StartGate::Requirement>{{estimate_output_, required}},
      [this] { start(); });
}

void EkfIdentifierNode::start() {
  const ros::TransportHints no_delay = ros::TransportHints().tcpNoDelay();
  elements_subscriber_ = handle_.subscribe<ring_gyro::OrbitalElements>(
      bridge::topics::kOrbitalElements, kInputQueue,
      [this](const ring_gyro::OrbitalElements::ConstPtr& message) {
        add(bridge::topics::kOrbitalElements, *message);
      },
      ros::VoidConstPtr(), no_delay);
  gains_subscriber_ = handle_.subscribe<ring_gyro::ControlGains>(
      bridge::topics::kControlGains, kInputQueue,
      [this](const ring_gyro::ControlGains::ConstPtr& message) {
        add(bridge::topics::kControlGains, *message);
      },
      ros::VoidConstPtr(), no_delay);
}

void EkfIdentifierNode::take(const cvg::ParameterEstimate& estimate) {
  if (!estimate.isFinite()) {
    host_.fail("the estimate of block " + std::to_string(estimate.stamp.sequence) +
               " is not finite");
    return;
  }
  const auto message = boost::make_shared<ring_gyro::ParameterEstimate>();
  bridge::toMessage(estimate, *message);
  estimate_output_.publish(message);
}

template <typename Message>
void EkfIdentifierNode::add(const char* topic, const Message& message) {
  if (const bridge::MessageFault fault = identifier_.add(message)) {
    refusals_.add(topic, message.sequence, fault);
  }
  if (const cvg::BlockStamp* const last = identifier_.last()) {
    departure_.inSession(last->session);
    departure_.processed(last->sequence);
  } else {
    departure_.inSession(message.session);
  }
  if (replay_end_) replay_end_->received();
}

void EkfIdentifierNode::leave() {
  elements_subscriber_.shutdown();
  gains_subscriber_.shutdown();
  identifier_.flush();
  bridge::IdentificationResult result;
  result.report = identifier_.report();
  result.report.not_delivered = not_delivered_;
  if (!parameters_.replay.empty()) result.sources.push_back(parameters_.replay);
  const std::string failure = bridge::failureOf(result.report, configuration_);
  if (!failure.empty()) ROS_WARN("not identified: %s", failure.c_str());
  for (const std::string& fault : bridge::faultsOf(result.report, configuration_)) {
    ROS_WARN("%s", fault.c_str());
  }
  ROS_INFO("identification\n%s", bridge::identificationText(result, configuration_).c_str());
  try {
    report_file_.finish(bridge::identificationJson({result}, configuration_));
  } catch (const std::exception& error) {
    host_.fail(error.what());
  }
}

void EkfIdentifierNode::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const bridge::IdentificationReport now = identifier_.report();
  const cvg::PairMerge::Counts& counts = now.pairs;
  const cvg::TimeGuard::Counts& elements = now.elements;
  const cvg::TimeGuard::Counts& gains = now.gains;
  const std::uint64_t lost =
      elements.lost + gains.lost + counts.elements_alone + counts.gains_alone;
  const std::string none_used = use_.noneSinceLast(now.uses);
  const std::string misfit = now.nis.misfit();
  if (counts.overdue > 0 && counts.pairs == 0) {
    status.summary(DiagnosticStatus::WARN,
                   "one of orbital elements and control gains is silent, the other has come");
  } else if (counts.pairs == 0) {
    status.summary(DiagnosticStatus::OK, "waiting for orbital elements and control gains");
  } else if (!none_used.empty()) {
    status.summary(DiagnosticStatus::WARN, none_used);
  } else if (!misfit.empty()) {
    status.summary(DiagnosticStatus::WARN, misfit);
  } else if (lost > 0) {
    status.summary(DiagnosticStatus::WARN, "identifying, blocks have been lost");
  } else {
    status.summary(DiagnosticStatus::OK,
                   now.estimate && now.estimate->converged ? "converged" : "identifying");
  }
  status.add("blocks", counts.pairs);
  status.add("elements without gains", counts.elements_alone);
  status.add("gains without elements", counts.gains_alone);
  status.add("lost blocks", elements.lost);
  status.add("duplicates", elements.duplicates + gains.duplicates);
  status.add("steps back", elements.steps_back);
  status.add("zero stamps", elements.zero_stamps + gains.zero_stamps);
  status.add("new sessions", elements.new_sessions);
  status.add("restarts of the filter", now.filter_restarts);
  status.add("blocks that wait for the other topic", identifier_.waiting());
  status.add("partner silent for too long", counts.overdue);
  status.add("blocks of a session that was left", elements.left_sessions + gains.left_sessions);
  status.add("ends of other sessions", departure_.foreign());
  UseWatch::addTo(status, now.uses);
  refusals_.addTo(status);
  if (!now.estimate) return;
  status.add("used blocks", now.estimate->used_blocks);
  status.add("rejected blocks", now.estimate->rejected_blocks);
  const char* const names[] = {"a [V]", "b [V]", "gamma 1",   "gamma 2",
                               "mu 1",  "mu 2",  "ks [1/s^2]"};
  const cvg::StateMatrix covariance = now.estimate->covariance.matrix();
  for (int i = 0; i < 7; ++i) {
    status.addf(names[i], "%.9g +- %.2g", now.estimate->value[i], std::sqrt(covariance(i, i)));
  }
}

}  // namespace ring_gyro::nodes
