#pragma once

#include <cstddef>
#include <vector>

#include "ring_gyro/analysis/rate_harmonics.h"

namespace cvg {

/// Allan deviation of a rate at one averaging time.
struct AllanPoint {
  double time = 0.0;            ///< tau, averaging time [s]
  double deviation = 0.0;       ///< of the rate averaged over tau [unit of the angle / s]
  double relative_sigma = 0.0;  ///< of the deviation, from the number of independent averages
};

/// Overlapping Allan deviation of the rate whose integral is `angles`, sampled each `period` [s]:
///
///     sigma^2(tau) = mean over k of (angle[k + 2 m] - 2 angle[k + m] + angle[k])^2 / (2 tau^2),
///
/// tau = m period, where m grows by a constant factor up to a third of the series. Empty for fewer
/// than three angles. Throws std::invalid_argument when an angle is not finite or the period is not
/// above zero.
std::vector<AllanPoint> allanDeviation(const std::vector<double>& angles, double period,
                                       int points_per_octave = 4);

/// The longest stretch of samples at equal times without a gap, as indices first <= i < end.
struct SampleStretch {
  std::size_t first = 0;
  std::size_t end = 0;
};
SampleStretch longestStretch(const std::vector<AngleSample>& samples, double period);

/// The angle without the fitted rate: theta minus the integral of fit.rate(theta), starting from 0
/// at samples[stretch.first] [rad].
std::vector<double> angleResidual(const std::vector<AngleSample>& samples,
                                  const SampleStretch& stretch, const RateHarmonics& fit);

}  // namespace cvg
