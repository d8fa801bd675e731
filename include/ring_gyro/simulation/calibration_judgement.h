#pragma once

#include <functional>

#include "ring_gyro/common/angle_harmonics.h"
#include "ring_gyro/simulation/loop_configuration.h"

namespace cvg {

/// A simulated gyroscope on a rate table, judged with the true values, which only a simulation
/// knows. All rates are those of the case, as the gyroscope reports them with its nominal k.
struct CalibrationJudgement {
  double rate = 0.0;                ///< of the case, and its opposite [rad/s]
  double forward_peak = 0.0;        ///< harmonics of the output rate, peak to peak [rad/s]
  double backward_peak = 0.0;       ///< the same at the opposite rate [rad/s]
  AngleHarmonics drift;             ///< even part of the output rate [rad/s]
  double drift_peak_to_peak = 0.0;  ///< [rad/s]
  double threshold = 0.0;           ///< largest |drift| over a turn, the constant included [rad/s]
  AngleHarmonics angle_error;       ///< output angle minus true angle of the pattern [rad]
  /// Largest |d output angle / d true angle - 1| over a turn.
  double slope_error = 0.0;
};

/// Turns the case of `configuration`, with its calibration and noise, at `rate` [rad/s] both ways
/// for `time` [s] each after the settling, but for at least a turn and a quarter of the pattern;
/// steering is off. `progress`: share done, may be empty.
/// Throws std::runtime_error when the loops do not lock, std::invalid_argument when the pattern
/// does not turn.
CalibrationJudgement judgeCalibration(LoopConfiguration configuration, double rate, double time,
                                      const std::function<void(double)>& progress = {});

}  // namespace cvg
