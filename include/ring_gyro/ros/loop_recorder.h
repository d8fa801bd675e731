#pragma once

#include <string>

#include "ring_gyro/ros/bag_writer.h"
#include "ring_gyro/ros/messages.h"
#include "ring_gyro/simulation/closed_loop.h"

namespace ring_gyro::bridge {

/// Records a loop that runs in one process, with the messages and topics of the graph.
class LoopRecorder {
 public:
  /// `raw`: also records displacement blocks and drive commands, by far the largest messages.
  /// Throws std::runtime_error when the file cannot be written, as all functions here do.
  LoopRecorder(const std::string& path, bool raw);

  void write(const cvg::LoopRecord& record);
  /// `last`: stamp of the last block; `cut`: the run was interrupted, so no end is announced.
  void finish(const cvg::BlockStamp& last, bool cut = false);

  std::uint64_t messages() const { return writer_.messages(); }

 private:
  template <typename Message>
  void write(const char* topic, Message& message);

  BagWriter writer_;
  bool raw_;
  ring_gyro::DisplacementBlock displacement_;
  ring_gyro::DriveCommand command_;
  ring_gyro::OrbitalElements elements_;
  ring_gyro::ControlGains gains_;
  ring_gyro::ParameterEstimate estimate_;
  ring_gyro::CompensationGains compensation_;
  ring_gyro::PlantTruth truth_;
};

}  // namespace ring_gyro::bridge
