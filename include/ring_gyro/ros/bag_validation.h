#pragma once

#include <string>
#include <vector>

#include "ring_gyro/ros/loop_bag.h"

namespace ring_gyro::bridge {

enum class Severity { kWarning, kFault };

/// One line about a recorded run.
struct Finding {
  Severity severity;
  std::string text;
};

/// Faults of a recorded run that can be found from the data alone, without a configuration. With
/// warnings the run is usable; with faults it is not, or its results would be wrong.
struct BagValidation {
  std::string summary;  ///< the data that were checked
  std::vector<Finding> findings;

  bool hasFault() const;
};

/// Throws BagError when the bag cannot be checked (see LoopBag).
BagValidation validateBag(const std::string& path, const LoopTopics& topics = {});

}  // namespace ring_gyro::bridge
