#pragma once

#include <ros/node_handle.h>
#include <ros/service_server.h>
#include <ros/subscriber.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <cstdint>
#include <memory>
#include <optional>

#include "ring_gyro/compensation/compensation_injector.h"
#include "ring_gyro/nodes/departure.h"
#include "ring_gyro/nodes/node_diagnostics.h"
#include "ring_gyro/nodes/node_host.h"
#include "ring_gyro/nodes/output.h"
#include "ring_gyro/nodes/refusals.h"
#include "ring_gyro/nodes/start_gate.h"
#include "ring_gyro/ros/messages.h"
#include "ring_gyro/ros/node_configuration.h"
#include "ring_gyro/signals/compensation_decision.h"
#include "ring_gyro/signals/time_guard.h"

namespace ring_gyro::nodes {

/// Decides on the compensation. Input: ParameterEstimate. Output: one CompensationGains (latched)
/// per estimate. Services ~enable, ~hold and ~reset act from the next decision on. An estimate with
/// impossible numbers counts as not converged: there is a decision, and the gains stay.
class CompensationInjectorNode {
 public:
  /// Throws std::invalid_argument, naming a parameter that cannot be used.
  CompensationInjectorNode(const ros::NodeHandle& handle, ros::NodeHandle private_handle,
                           const bridge::NodeConfiguration& configuration, NodeHost host);

 private:
  void start();
  void onEstimate(const ring_gyro::ParameterEstimate& message);
  bool enable(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);
  bool hold(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);
  bool reset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  void leave();
  void report(diagnostic_updater::DiagnosticStatusWrapper& status) const;

  ros::NodeHandle handle_;
  std::uint64_t period_blocks_;
  std::int64_t block_duration_ns_;
  cvg::CompensationInjector injector_;
  cvg::TimeGuard guard_;
  Refusals refusals_;
  cvg::ParameterEstimate estimate_;
  std::optional<cvg::CompensationDecision> decision_;
  std::uint64_t decisions_ = 0;

  Output gains_;
  ros::Subscriber estimate_subscriber_;
  ros::ServiceServer enable_service_;
  ros::ServiceServer hold_service_;
  ros::ServiceServer reset_service_;
  std::unique_ptr<StartGate> gate_;
  Departure departure_;
  NodeDiagnostics diagnostics_;
};

}  // namespace ring_gyro::nodes
