#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>

#include <cstdint>
#include <memory>

#include "ring_gyro/common/whole_file.h"
#include "ring_gyro/nodes/departure.h"
#include "ring_gyro/nodes/node_diagnostics.h"
#include "ring_gyro/nodes/node_host.h"
#include "ring_gyro/nodes/output.h"
#include "ring_gyro/nodes/refusals.h"
#include "ring_gyro/nodes/replay_end.h"
#include "ring_gyro/nodes/start_gate.h"
#include "ring_gyro/nodes/use_watch.h"
#include "ring_gyro/ros/messages.h"
#include "ring_gyro/ros/node_configuration.h"
#include "ring_gyro/ros/stream_identifier.h"

namespace ring_gyro::nodes {

/// The Kalman filter. Input: OrbitalElements and ControlGains through one merge. Output: a
/// ParameterEstimate at the end of each period (latched). Ends with the run or with the replayed
/// bag; then it writes the same report as the tool `identify`, if node/report is set.
class EkfIdentifierNode {
 public:
  /// Throws std::invalid_argument, naming a parameter that cannot be used, and std::runtime_error
  /// when the report cannot be written.
  EkfIdentifierNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                    const bridge::NodeConfiguration& configuration, NodeHost host);

 private:
  void start();
  void take(const cvg::ParameterEstimate& estimate);
  template <typename Message>
  void add(const char* topic, const Message& message);
  void leave();
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle handle_;
  NodeHost host_;
  cvg::LoopConfiguration configuration_;
  cvg::NodeParameters parameters_;
  cvg::WholeFile report_file_;
  bridge::StreamIdentifier identifier_;
  std::uint64_t not_delivered_ = 0;  // messages of the replayed bag
  Refusals refusals_;
  UseWatch use_;

  Output estimate_output_;
  ros::Subscriber elements_subscriber_;
  ros::Subscriber gains_subscriber_;
  std::unique_ptr<StartGate> gate_;
  Departure departure_;
  std::unique_ptr<ReplayEnd> replay_end_;
  NodeDiagnostics diagnostics_;
};

}  // namespace ring_gyro::nodes
