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

/// What is wrong with a recorded run as far as the data themselves can tell, without a
/// configuration: warnings leave it usable, faults do not, or make its results wrong.
struct BagValidation {
  std::string summary;  ///< what was looked at
  std::vector<Finding> findings;

  bool hasFault() const;
};

/// Throws BagError when there is nothing to look at (see LoopBag).
BagValidation validateBag(const std::string& path, const LoopTopics& topics = {});

}  // namespace ring_gyro::bridge
