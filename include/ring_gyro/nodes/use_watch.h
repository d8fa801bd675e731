#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <string>

#include "ring_gyro/identification/filter/block_use.h"

namespace ring_gyro::nodes {

/// Text about unusable blocks for /diagnostics, for the time since the last report.
class UseWatch {
 public:
  /// `uses`: counts of all blocks so far. Gives "none of the last 1000 blocks can be used: 1000 not
  /// locked"; empty when one of them could be used, or when no block arrived.
  std::string noneSinceLast(const cvg::BlockUseCounts& uses);

  static void addTo(diagnostic_updater::DiagnosticStatusWrapper& status,
                    const cvg::BlockUseCounts& uses);

 private:
  cvg::BlockUseCounts last_;
};

}  // namespace ring_gyro::nodes
