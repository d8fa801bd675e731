#include "ring_gyro/nodes/compensation_injector_node.h"

#include <ros/console.h>

#include <string>
#include <utility>
#include <vector>

#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/ros/message_checks.h"
#include "ring_gyro/ros/topics.h"
#include "ring_gyro/signals/compensation_decision.h"

namespace ring_gyro::nodes {

CompensationInjectorNode::CompensationInjectorNode(const ros::NodeHandle& handle,
                                                   ros::NodeHandle private_handle,
                                                   const bridge::NodeConfiguration& configuration,
                                                   NodeHost host)
    : handle_(handle),
      period_blocks_(configuration.loop.periodBlocks()),
      block_duration_ns_(configuration.loop.converter.blockDurationNanoseconds()),
      injector_(configuration.loop.device, configuration.loop.compensation,
                static_cast<std::int64_t>(period_blocks_)),
      gains_(Output::advertise<ring_gyro::CompensationGains>(
          handle_, bridge::topics::kCompensationGains, true)),
      enable_service_(
          private_handle.advertiseService("enable", &CompensationInjectorNode::enable, this)),
      hold_service_(private_handle.advertiseService("hold", &CompensationInjectorNode::hold, this)),
      reset_service_(
          private_handle.advertiseService("reset", &CompensationInjectorNode::reset, this)),
      departure_(handle_, configuration.node, std::move(host), {gains_}, [this] { leave(); }),
      diagnostics_(handle_, private_handle, private_handle.getNamespace(),
                   [this](auto& status) { report(status); }) {
  const auto required = static_cast<std::size_t>(configuration.node.required_subscribers);
  gate_ = std::make_unique<StartGate>(
      handle_, std::vector<StartGate::Requirement>{{gains_, required}}, [this] { start(); });
}

void CompensationInjectorNode::start() {
  estimate_subscriber_ = handle_.subscribe<ring_gyro::ParameterEstimate>(
      bridge::topics::kParameterEstimate, kInputQueue,
      [this](const ring_gyro::ParameterEstimate::ConstPtr& message) { onEstimate(*message); },
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
}

void CompensationInjectorNode::onEstimate(const ring_gyro::ParameterEstimate& message) {
  bridge::fromMessage(message, estimate_);
  const cvg::StampOrder order = guard_.check(estimate_.stamp);
  if (!cvg::isUsable(order)) {
    refusals_.add(bridge::topics::kParameterEstimate,
                  order == cvg::StampOrder::kZero        ? "with a stamp of zero"
                  : order == cvg::StampOrder::kDuplicate ? "that came twice"
                                                         : "of a session that was left",
                  "block " + std::to_string(message.last_sequence) + " of session " +
                      std::to_string(message.session) + "; is there one identifier only?");
    return;
  }
  departure_.inSession(message.session);
  if (const bridge::MessageFault fault = bridge::faultOf(message)) {
    refusals_.add(bridge::topics::kParameterEstimate, message.last_sequence, fault);
    const cvg::BlockStamp stamp = estimate_.stamp;
    estimate_ = cvg::ParameterEstimate();
    estimate_.stamp = stamp;
    estimate_.stamp.duration_ns = block_duration_ns_;
  }
  decision_ = injector_.decide(estimate_);
  ++decisions_;
  const auto gains = boost::make_shared<ring_gyro::CompensationGains>();
  bridge::toMessage(*decision_, message.header.stamp, *gains);
  gains_.publish(gains);
  // No estimate covers the blocks after the last whole period.
  departure_.processed(estimate_.stamp.sequence + period_blocks_ - 1);
}

bool CompensationInjectorNode::enable(std_srvs::SetBool::Request& request,
                                      std_srvs::SetBool::Response& response) {
  injector_.setEnabled(request.data != 0);
  response.success = true;
  response.message = request.data ? "compensation follows the estimates"
                                  : "compensation ramps to zero and stays there";
  return true;
}

bool CompensationInjectorNode::hold(std_srvs::SetBool::Request& request,
                                    std_srvs::SetBool::Response& response) {
  injector_.setHold(request.data != 0);
  response.success = true;
  response.message =
      request.data ? "compensation stays as it is" : "compensation follows the estimates again";
  return true;
}

bool CompensationInjectorNode::reset(std_srvs::Trigger::Request&,
                                     std_srvs::Trigger::Response& response) {
  injector_.reset();
  response.success = true;
  response.message = "compensation is zero from the next decision on";
  return true;
}

void CompensationInjectorNode::leave() {
  estimate_subscriber_.shutdown();
  if (!decision_) {
    ROS_WARN("the run ended before the first decision");
    return;
  }
  ROS_INFO("last of %lu decisions: %s, cancels gamma (%.6f, %.6f)",
           static_cast<unsigned long>(decisions_), cvg::toString(decision_->state),
           decision_->gamma1, decision_->gamma2);
}

void CompensationInjectorNode::report(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  using diagnostic_msgs::DiagnosticStatus;
  if (!decision_) {
    status.summary(DiagnosticStatus::OK, "waiting for estimates");
    refusals_.addTo(status);
    return;
  }
  const bool limited = decision_->state == cvg::InjectorState::kLimited;
  const bool refused = refusals_.total() > 0;
  status.summary(limited || refused ? DiagnosticStatus::WARN : DiagnosticStatus::OK,
                 std::string(cvg::toString(decision_->state)) +
                     (refused ? ", estimates have been refused" : ""));
  status.add("decisions", decisions_);
  status.add("effective sequence", decision_->effective_sequence);
  status.add("gamma 1 cancelled", decision_->gamma1);
  status.add("gamma 2 cancelled", decision_->gamma2);
  status.add("ends of other sessions", departure_.foreign());
  refusals_.addTo(status);
}

}  // namespace ring_gyro::nodes
