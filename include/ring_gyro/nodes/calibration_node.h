#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>

#include <memory>
#include <optional>
#include <string>

#include "ring_gyro/calibration/calibration_procedure.h"
#include "ring_gyro/common/staged_file.h"
#include "ring_gyro/nodes/departure.h"
#include "ring_gyro/nodes/node_diagnostics.h"
#include "ring_gyro/nodes/node_host.h"
#include "ring_gyro/nodes/output.h"
#include "ring_gyro/nodes/refusals.h"
#include "ring_gyro/nodes/start_gate.h"
#include "ring_gyro/nodes/use_watch.h"
#include "ring_gyro/ros/messages.h"
#include "ring_gyro/ros/node_configuration.h"
#include "ring_gyro/signals/calibration_command.h"
#include "ring_gyro/signals/pair_merge.h"

namespace ring_gyro::nodes {

/// Makes a calibration run. Input: OrbitalElements and ControlGains through one merge. Output: a
/// CalibrationCommand at the end of each period (latched), and at the end of the run the
/// calibration as YAML in node/calibration_file.
///
/// The last command makes the plant end the run. If the run cannot continue, this command contains
/// the reason, and the node fails after the others have exited; the calibration so far stays in a
/// file with the name of node/calibration_file plus ".partial".
class CalibrationNode {
 public:
  /// Throws ConfigurationError or std::invalid_argument, naming a parameter that cannot be used,
  /// and std::runtime_error when the file cannot be written.
  CalibrationNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                  const bridge::NodeConfiguration& configuration, NodeHost host);

 private:
  void start();
  void process(const cvg::OrbitalElements& elements, const cvg::ControlGains& gains);
  void publish(const cvg::CalibrationCommand& command, const cvg::BlockStamp& data);
  void keep();
  void conclude();
  void fail(const std::string& why);
  void leave();
  void finish();
  template <typename Message, typename Signal>
  void add(const char* topic, const Message& message, Signal& signal);
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle handle_;
  cvg::NodeParameters parameters_;
  cvg::DeviceKnowledge device_;
  NodeHost host_;
  cvg::CalibrationProcedure procedure_;
  cvg::PairMerge merge_;
  cvg::OrbitalElements elements_;
  cvg::ControlGains gains_;
  std::int64_t block_duration_ns_;
  Refusals refusals_;
  cvg::BlockUseCounts uses_;
  UseWatch use_;
  std::optional<cvg::BlockStamp> last_;
  std::optional<cvg::CalibrationCommand> command_;
  cvg::StagedFile file_;
  bool written_ = false;
  std::string failure_;

  Output output_;
  ros::Subscriber elements_subscriber_;
  ros::Subscriber gains_subscriber_;
  std::unique_ptr<StartGate> gate_;
  Departure departure_;
  NodeDiagnostics diagnostics_;
};

}  // namespace ring_gyro::nodes
