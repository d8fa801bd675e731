#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "ring_gyro/common/parameter_table.h"

namespace cvg {

/// How a node of the graph behaves; the same section serves every node, the offline tools check it
/// and pass it over.
struct NodeParameters {
  bool lockstep = true;           ///< each block waits for the answer to the one before
  double lockstep_timeout = 5.0;  ///< wall time of silence after which a run is given up [s]
  std::int64_t required_subscribers = 0;  ///< that each output needs before the node takes input
  std::int64_t recorders = 0;      ///< listeners to end_of_run that do not leave by themselves
  double exit_timeout = 10.0;      ///< wall time that the plant waits for the others to end [s]
  std::int64_t burst_blocks = 20;  ///< whose elements, gains and truth go together in lockstep
  double clock_rate = 100.0;       ///< of /clock, in wall time [Hz]
  std::string imu_frame = "ring_gyro";  ///< frame_id of the sensed rate

  std::string watched;             ///< nodes whose death ends the run, blanks between
  std::string configuration_file;  ///< that these parameters come from
  std::string calibration_read;    ///< calibration that these parameters come from too

  std::string bag;          ///< file that the recorder writes
  bool record_raw = false;  ///< samples and drive commands are recorded too

  std::string calibration_file;  ///< YAML that a calibration run writes

  std::string report;            ///< JSON that the identifier writes at its end
  std::string replay;            ///< bag whose replay the identifier listens to; it ends with it
  double replay_start = 0.0;     ///< where that replay begins, from the begin of the bag [s]
  double replay_duration = 0.0;  ///< of that replay; 0: to the end of the bag [s]
  double replay_timeout = 10.0;  ///< wall time of silence that ends a replay without /clock [s]

  /// Listeners that samples and drive commands must have before the first of them: the other end of
  /// the loop, and the recorder if it wants them.
  std::size_t blockListeners() const { return record_raw ? 2 : 1; }

  void declare(ParameterTable& table);
};

}  // namespace cvg
