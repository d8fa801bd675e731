#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ring_gyro/resonator/plant_simulator.h"
#include "ring_gyro/ros/loop_bag.h"
#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace ring_gyro::bridge {

/// Elements and gains of one block, and the rotation of the case in it.
struct RecordedPair {
  cvg::OrbitalElements elements;
  cvg::ControlGains gains;
  double rotation_rate = 0.0;  ///< as the truth of a simulated run says; 0 without [rad/s]
};

/// A recorded run in memory, about 0.4 kB a block.
struct RecordedRun {
  std::vector<RecordedPair> pairs;
  std::optional<cvg::PlantTruth> truth;  ///< the last, of a simulated run
  std::vector<std::string> damage;       ///< what could not be read, one line each
};

/// Reads one run, which may be split over several bags: pairs by cvg::PairMerge, the truth where a
/// bag has it. `start` and `duration` (0: to the end) in bag time from the begin [s]. Throws
/// BagError.
RecordedRun readRecordedRun(const std::vector<std::string>& paths, const LoopTopics& topics = {},
                            double start = 0.0, double duration = 0.0);

}  // namespace ring_gyro::bridge
