#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "ring_gyro/common/parameter_table.h"

namespace cvg {

/// Settings of a node of the graph. Every node has the same section; the offline tools check it but
/// do not use it.
struct NodeParameters {
  bool lockstep = true;                   ///< each block waits for the answer to the previous one
  double lockstep_timeout = 5.0;          ///< wall time without an answer that ends the run [s]
  std::int64_t required_subscribers = 0;  ///< that each output needs before the node takes input
  std::int64_t recorders = 0;      ///< subscribers of end_of_run that stay until they are stopped
  double exit_timeout = 10.0;      ///< wall time that the plant waits for the others to exit [s]
  std::int64_t burst_blocks = 20;  ///< blocks whose messages are sent together in lockstep
  double clock_rate = 100.0;       ///< of /clock, in wall time [Hz]
  std::string imu_frame = "ring_gyro";  ///< frame_id of the sensed rate

  std::string watched;             ///< nodes whose death ends the run, separated by blanks
  std::string configuration_file;  ///< file of these parameters
  std::string calibration_read;    ///< calibration file of these parameters

  std::string bag;          ///< file that the recorder writes
  bool record_raw = false;  ///< samples and drive commands are recorded too

  std::string calibration_file;  ///< YAML that a calibration run writes

  std::string report;            ///< JSON that the identifier writes at its end
  std::string replay;            ///< bag whose replay the identifier listens to and ends with
  double replay_start = 0.0;     ///< start of that replay, from the beginning of the bag [s]
  double replay_duration = 0.0;  ///< of that replay; 0: to the end of the bag [s]
  double replay_timeout = 10.0;  ///< wall time of silence that ends a replay without /clock [s]

  /// Subscribers that samples and drive commands need before the first message: the other end of
  /// the loop, and the recorder if it records them.
  std::size_t blockListeners() const { return record_raw ? 2 : 1; }

  void declare(ParameterTable& table);
};

}  // namespace cvg
