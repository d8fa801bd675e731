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

/// The Kalman filter: OrbitalElements and ControlGains in through one merge, ParameterEstimate out
/// at the end of each period (latched). Ends with the run, or with the bag that is replayed to it,
/// and then writes the report that the tool `identify` makes of a bag, if it is told where.
class EkfIdentifierNode {
 public:
  /// Throws std::invalid_argument naming what cannot be used, std::runtime_error when the report
  /// cannot be written.
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
  std::uint64_t not_delivered_ = 0;  // of the bag that is replayed
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
