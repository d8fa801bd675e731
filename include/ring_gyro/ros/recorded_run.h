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
  double rotation_rate = 0.0;  ///< from the truth of a simulated run; 0 without it [rad/s]
};

/// A recorded run in memory, about 0.4 kB per block.
struct RecordedRun {
  std::vector<RecordedPair> pairs;
  std::optional<cvg::PlantTruth> truth;  ///< the last, of a simulated run
  std::vector<std::string> damage;       ///< unreadable parts, one line each
};

/// Reads one run, which may be split over several bags: pairs by cvg::PairMerge, the truth if a
/// bag has it. `start` and `duration` (0: to the end) are bag time from the beginning [s]. Throws
/// BagError.
RecordedRun readRecordedRun(const std::vector<std::string>& paths, const LoopTopics& topics = {},
                            double start = 0.0, double duration = 0.0);

}  // namespace ring_gyro::bridge
