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
  int whole_turns = 0;                     ///< that were used
  double begin_time = 0.0;                 ///< of the samples that were used [s]
  double end_time = 0.0;                   ///< [s]

  double amplitude(int harmonic) const;  ///< harmonic from 1 to kCount [rad/s]
  double phase(int harmonic) const;      ///< rate = amplitude cos(n theta - phase) [rad]
  double rate(double theta) const;       ///< the whole fit [rad/s]
};

/// Fits the rate against the angle over the last whole turns of a series sampled at equal times.
///
/// Neighbouring windows of `window` seconds are averaged and differenced, so that white noise of
/// the angle stays small. What is fitted to the difference is not the harmonics at one angle but
/// their mean with the weights by which the true rate enters it (a triangle two windows wide, over
/// the measured angles), so neither the window nor a rate that changes within it biases the result.
/// Missing samples cost the windows that they lie in, nothing else.
/// Throws std::invalid_argument when a sample is not finite, times do not grow, the window is under
/// two samples, less than one whole turn was made, or windows are too few for the fit.
RateHarmonics fitRateHarmonics(const std::vector<AngleSample>& samples, double window = 0.1);

/// A window for the fit of these samples, which are `period` apart [s]: 0.1 s, or less where that
/// is not short against a turn; two samples at least. There must be a sample.
double windowOfTurns(const std::vector<AngleSample>& samples, double period);

/// The rates of neighbouring windows by themselves, over all samples.
/// Throws like fitRateHarmonics, but asks for no turn.
std::vector<RateSample> windowedRates(const std::vector<AngleSample>& samples, double window = 0.1);

}  // namespace cvg
