#pragma once

#include <string>

#include "ring_gyro/ros/bag_writer.h"
#include "ring_gyro/ros/messages.h"
#include "ring_gyro/simulation/closed_loop.h"

namespace ring_gyro::bridge {

/// Writes what a loop in one process brings about, as the messages on the topics that the graph
/// has.
class LoopRecorder {
 public:
  /// `raw`: the displacement blocks and drive commands too, by far the largest.
  /// Throws std::runtime_error when the file cannot be written, as everything here does.
  LoopRecorder(const std::string& path, bool raw);

  void write(const cvg::LoopRecord& record);
  /// `last`: stamp of the last block; `cut`: the run was to go on, so that nobody announces an end.
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
