#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "ring_gyro/common/parameter_table.h"
#include "ring_gyro/simulation/loop_configuration.h"

namespace cvg {

/// Differences of squared tuning voltages [V^2] that soften along (0 minus 90 degrees) and across
/// (45 minus 135 degrees) the axes.
struct TuningSquares {
  double along = 0.0;
  double across = 0.0;

  static TuningSquares of(const ResonatorParameters& ring);
  /// One electrode of each pair gets the voltage, the other zero.
  void applyTo(ResonatorParameters& ring) const;
};

/// One pass of the tuning: the voltages, and the result of the identifier with them.
struct TuningPass {
  TuningSquares squares;
  double mu1 = 0.0;
  double mu2 = 0.0;
  double sigma = 0.0;       ///< of mu
  double split = 0.0;       ///< f0 |mu|, as identified [Hz]
  double true_split = 0.0;  ///< of the simulated ring [Hz]
};

struct TuningOptions {
  double assumed_tuning_gain = 0.0;   ///< softening per V^2 from the layout [1/V^2]
  double identification_time = 30.0;  ///< of each pass, after the lock [s]
  double target_split = 1e-4;         ///< stop below this [Hz]
  std::int64_t most_passes = 6;

  void declare(ParameterTable& table);
};

/// Computes tuning voltages from the identified stiffness mismatch, second term of (8): mu falls by
/// half the softening, so an additional softening of 2 mu cancels it. After the first correction
/// the softening per V^2 comes from the measured effect of the voltages.
///
/// Each pass runs the closed loop of `configuration` (its steering must move the pattern),
/// identifies mu and corrects. `seen` is called after each pass. Throws std::runtime_error when one
/// does not converge.
std::vector<TuningPass> tuneModes(LoopConfiguration configuration, const TuningOptions& options,
                                  const std::function<void(const TuningPass&)>& seen);

}  // namespace cvg
