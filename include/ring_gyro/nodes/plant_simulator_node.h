#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <ros/wall_timer.h>
#include <rosgraph_msgs/Clock.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "ring_gyro/nodes/node_diagnostics.h"
#include "ring_gyro/nodes/node_host.h"
#include "ring_gyro/nodes/output.h"
#include "ring_gyro/nodes/reader_wait.h"
#include "ring_gyro/nodes/refusals.h"
#include "ring_gyro/nodes/start_gate.h"
#include "ring_gyro/resonator/plant_simulator.h"
#include "ring_gyro/ros/message_pool.h"
#include "ring_gyro/ros/messages.h"
#include "ring_gyro/ros/node_configuration.h"

namespace ring_gyro::nodes {

/// The gyroscope. Input: DriveCommand. Output: DisplacementBlock, /clock, the truth and the end of
/// the run.
///
/// Lockstep: block n + 1 follows the command that answers block n. Real time: one block per block
/// duration of wall time; without a new command the last drive continues.
class PlantSimulatorNode {
 public:
  /// Throws std::invalid_argument, naming a parameter that cannot be used.
  PlantSimulatorNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                     const bridge::NodeConfiguration& configuration, NodeHost host);

 private:
  using WallClock = std::chrono::steady_clock;

  void start();
  void onDriveCommand(const ring_gyro::DriveCommand& message);
  bool accepts(const ring_gyro::DriveCommand& message);
  void goOn();
  void step();
  void onRealTimeTick();
  void publish(const cvg::DisplacementBlock& block);
  void sendTruths();
  void publishClock(const cvg::BlockStamp& stamp);
  void endRun();
  void watch();
  void watchSilence();
  void watchNodes();
  void reportProgress();
  void waitForListeners();
  void report(diagnostic_updater::DiagnosticStatusWrapper& status) const;
  double simulatedTime() const;
  bool lastBlockDone() const;
  double behindRealTime() const;  // delay of the next block's start [s]; negative: not due yet

  ros::NodeHandle handle_;
  cvg::NodeParameters parameters_;
  NodeHost host_;
  double duration_;             // of the run, 0: until stopped [s]
  std::uint64_t blocks_;        // of the run, 0: until stopped
  std::uint64_t burst_blocks_;  // blocks whose truth is sent together
  std::int64_t block_ns_;
  std::int64_t start_ns_;
  cvg::PlantSimulator plant_;
  cvg::DriveCommand command_;
  bool commanded_ = false;    // real time: a command has arrived since the last block
  bool any_command_ = false;  // at least one command has been accepted
  bool coasts_ = false;       // lockstep: the answer was refused, the last drive continues
  cvg::BlockStamp last_;
  bool started_ = false;
  bool ended_ = false;

  std::uint64_t coasted_ = 0;
  std::uint64_t late_ = 0;
  int silent_ticks_ = 0;
  int ticks_ = 0;
  int ending_ticks_ = 0;
  double reported_time_ = 0.0;
  WallClock::time_point started_at_;
  WallClock::time_point reported_at_;
  WallClock::time_point clock_at_;

  bridge::MessagePool<ring_gyro::DisplacementBlock> displacement_messages_;
  bridge::MessagePool<ring_gyro::PlantTruth> truth_messages_;
  std::vector<ring_gyro::PlantTruth::ConstPtr> truth_burst_;
  Output displacement_;
  Output truth_;
  Output end_of_run_;
  ReaderWait reader_wait_;
  Refusals refusals_;
  ros::Publisher clock_;
  ros::Subscriber drive_subscriber_;
  std::unique_ptr<StartGate> gate_;
  ros::WallTimer watch_timer_;
  ros::WallTimer block_timer_;
  NodeDiagnostics diagnostics_;
};

}  // namespace ring_gyro::nodes
