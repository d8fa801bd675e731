#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <string>

#include "ring_gyro/identification/filter/block_use.h"

namespace ring_gyro::nodes {

/// What /diagnostics says of blocks that cannot be used, from one report to the next.
class UseWatch {
 public:
  /// Counts of all so far; gives "none of the last 1000 blocks can be used: 1000 not locked", empty
  /// when one could, or when none came.
  std::string noneSinceLast(const cvg::BlockUseCounts& uses);

  static void addTo(diagnostic_updater::DiagnosticStatusWrapper& status,
                    const cvg::BlockUseCounts& uses);

 private:
  cvg::BlockUseCounts last_;
};

}  // namespace ring_gyro::nodes
