#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <cstdint>
#include <string>

#include "ring_gyro/ros/identification_report.h"

namespace ring_gyro::nodes {

/// What /diagnostics says of blocks that cannot be used, from one report to the next.
class UseWatch {
 public:
  /// Counts of all so far; gives "none of the last 1000 blocks can be used: 1000 not locked", empty
  /// when one could, or when none came.
  std::string noneSinceLast(std::uint64_t usable, const bridge::UnusableBlocks& unusable);

  static void addTo(diagnostic_updater::DiagnosticStatusWrapper& status, std::uint64_t usable,
                    const bridge::UnusableBlocks& unusable);

 private:
  std::uint64_t usable_ = 0;
  bridge::UnusableBlocks unusable_;
};

}  // namespace ring_gyro::nodes
