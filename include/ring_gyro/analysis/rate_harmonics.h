#pragma once

#include <array>
#include <vector>

namespace cvg {

/// Pattern angle at one moment.
struct AngleSample {
  double time = 0.0;   ///< [s]
  double theta = 0.0;  ///< unwrapped over turns [rad]
};

/// Precession rate over one window, for plots.
struct RateSample {
  double time = 0.0;   ///< middle of the window [s]
  double theta = 0.0;  ///< mean over the window, unwrapped [rad]
  double rate = 0.0;   ///< [rad/s]
};

/// Precession rate as a function of the pattern angle,
/// rate(theta) = mean_rate + sum_n [cosine_n cos(n theta) + sine_n sin(n theta)].
struct RateHarmonics {
  static constexpr int kCount = 8;

  double mean_rate = 0.0;                  ///< mean over angle, not over time [rad/s]
  std::array<double, kCount> cosine = {};  ///< of n theta at index n - 1 [rad/s]
  std::array<double, kCount> sine = {};    ///< of n theta at index n - 1 [rad/s]
  double peak_to_peak = 0.0;               ///< of the sum of the harmonics [rad/s]
  double residual_rms = 0.0;               ///< of the windows' rates about the fit [rad/s]
  int whole_turns = 0;                     ///< number of turns used
  double begin_time = 0.0;                 ///< of the samples used [s]
  double end_time = 0.0;                   ///< [s]

  double amplitude(int harmonic) const;  ///< harmonic from 1 to kCount [rad/s]
  double phase(int harmonic) const;      ///< rate = amplitude cos(n theta - phase) [rad]
  double rate(double theta) const;       ///< the whole fit [rad/s]
};

/// Fits the rate against the angle over the last whole turns of a series with a constant sampling
/// period.
///
/// Neighbouring windows of `window` seconds are averaged and differenced, which reduces white noise
/// of the angle. The true rate enters the difference with known weights (a triangle two windows
/// wide, over the measured angles). The fit uses the mean of each harmonic with these weights, not
/// its value at one angle. So neither the window nor a rate that changes within it biases the
/// result. A missing sample removes only the windows that contain it.
/// Throws std::invalid_argument when a sample is not finite, times do not grow, the window is under
/// two samples, there is less than one whole turn, or there are too few windows for the fit.
RateHarmonics fitRateHarmonics(const std::vector<AngleSample>& samples, double window = 0.1);

/// A window for the fit of these samples, which are `period` apart [s]: 0.1 s, or less if 0.1 s is
/// not short compared with a turn; at least two samples. `samples` must not be empty.
double windowOfTurns(const std::vector<AngleSample>& samples, double period);

/// The rates from neighbouring windows, without a fit, over all samples.
/// Throws like fitRateHarmonics, but does not need a whole turn.
std::vector<RateSample> windowedRates(const std::vector<AngleSample>& samples, double window = 0.1);

}  // namespace cvg
