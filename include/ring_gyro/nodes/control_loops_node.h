#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <ros/wall_timer.h>
#include <sensor_msgs/Imu.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ring_gyro/control/control_loops.h"
#include "ring_gyro/nodes/departure.h"
#include "ring_gyro/nodes/node_diagnostics.h"
#include "ring_gyro/nodes/node_host.h"
#include "ring_gyro/nodes/output.h"
#include "ring_gyro/nodes/reader_wait.h"
#include "ring_gyro/nodes/refusals.h"
#include "ring_gyro/nodes/start_gate.h"
#include "ring_gyro/ros/message_pool.h"
#include "ring_gyro/ros/messages.h"
#include "ring_gyro/ros/node_configuration.h"
#include "ring_gyro/signals/calibration_command.h"
#include "ring_gyro/signals/compensation_decision.h"
#include "ring_gyro/signals/decision_queue.h"
#include "ring_gyro/signals/time_guard.h"

namespace ring_gyro::nodes {

/// Demodulation and control. Input: DisplacementBlock. Output: DriveCommand, OrbitalElements,
/// ControlGains and the sensed rate.
///
/// With compensation or in a calibration run the loops get a decision for each period. In lockstep
/// a block whose drive needs a decision waits for it, so that the timing of threads cannot change a
/// run. In real time decisions act when they arrive, and late ones are counted.
///
/// A block with impossible numbers is also answered, like one with invalid samples: the loops
/// coast, and the phase of the NCO continues from their last command.
class ControlLoopsNode {
 public:
  /// Throws std::invalid_argument, naming a parameter that cannot be used.
  ControlLoopsNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                   const bridge::NodeConfiguration& configuration, NodeHost host);

 private:
  using BlockMessage = ring_gyro::DisplacementBlock;

  void start();
  void onDisplacement(const BlockMessage::ConstPtr& message);
  template <typename Message, typename Decision>
  ros::Subscriber subscribeDecisions(const char* topic, cvg::DecisionQueue<Decision>& decisions);
  void processWaiting();
  bool mustWait(const BlockMessage& message);
  bool mustWaitForDecision(const BlockMessage& message) const;
  bool isNew(const BlockMessage& message);
  void read(const BlockMessage& message);
  void applyDecisions();
  void process(const BlockMessage& message);
  void publish(const cvg::LoopOutput& output);
  void sendBurst();
  void watchSilence();
  void leave();
  void report(diagnostic_updater::DiagnosticStatusWrapper& status) const;

  ros::NodeHandle handle_;
  cvg::NodeParameters parameters_;
  NodeHost host_;
  double angular_gain_;
  bool compensation_;
  bool calibration_run_;
  std::uint64_t period_blocks_;  // of the identifier
  cvg::ControlLoops loops_;
  cvg::DisplacementBlock block_;
  cvg::TimeGuard guard_;
  std::optional<std::uint32_t> unconfirmed_session_;  // one block arrived, but not its first
  BlockMessage::ConstPtr waiting_;  // for the decision that its answer needs, or for readers
  cvg::DecisionQueue<cvg::CompensationDecision> compensation_decisions_;
  cvg::DecisionQueue<cvg::CalibrationCommand> calibration_commands_;
  std::int64_t block_duration_ns_;
  cvg::LoopStatus status_;
  double amplitude_ = 0.0;
  double theta_rate_ = 0.0;

  std::uint64_t invalid_blocks_ = 0;
  int silent_ticks_ = 0;

  std::uint64_t burst_blocks_;
  std::vector<ring_gyro::OrbitalElements::ConstPtr> elements_burst_;
  std::vector<ring_gyro::ControlGains::ConstPtr> gains_burst_;
  bridge::MessagePool<ring_gyro::DriveCommand> command_messages_;
  bridge::MessagePool<ring_gyro::OrbitalElements> elements_messages_;
  bridge::MessagePool<ring_gyro::ControlGains> gains_messages_;
  bridge::MessagePool<sensor_msgs::Imu> imu_messages_;
  Output command_;
  Output elements_;
  Output gains_;
  Output imu_;
  ReaderWait reader_wait_;
  Refusals refusals_;
  ros::Subscriber displacement_subscriber_;
  ros::Subscriber decision_subscriber_;
  ros::WallTimer watch_timer_;
  std::unique_ptr<StartGate> gate_;
  Departure departure_;
  NodeDiagnostics diagnostics_;
};

}  // namespace ring_gyro::nodes
