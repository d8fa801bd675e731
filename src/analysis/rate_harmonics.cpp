#include "ring_gyro/analysis/rate_harmonics.h"

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <stdexcept>
#include <string>

#include "ring_gyro/common/angle.h"

namespace cvg {
namespace {

constexpr int kTerms = 1 + 2 * RateHarmonics::kCount;
using Terms = Eigen::Matrix<double, kTerms, 1>;

// 1, cos theta .. cos 8 theta, sin theta .. sin 8 theta.
Terms harmonicTerms(double theta) {
  Terms terms;
  terms(0) = 1.0;
  const std::complex<double> first = std::polar(1.0, theta);
  std::complex<double> power = first;
  for (int n = 1; n <= RateHarmonics::kCount; ++n) {
    terms(n) = power.real();
    terms(RateHarmonics::kCount + n) = power.imag();
    power *= first;
  }
  return terms;
}

Terms coefficients(const RateHarmonics& fit) {
  Terms result;
  result(0) = fit.mean_rate;
  for (int n = 1; n <= RateHarmonics::kCount; ++n) {
    result(n) = fit.cosine[n - 1];
    result(RateHarmonics::kCount + n) = fit.sine[n - 1];
  }
  return result;
}

// Samples at equal times without a gap: `count` of them from `first`.
struct Window {
  std::size_t first;
  std::size_t count;
};

// The usual step between samples: the median, which gaps do not change.
double samplePeriod(const std::vector<AngleSample>& samples) {
  if (samples.size() < 2) {
    throw std::invalid_argument("rate harmonics: under two samples of the angle");
  }
  std::vector<double> steps(samples.size() - 1);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    steps[i] = samples[i + 1].time - samples[i].time;
    if (!std::isfinite(samples[i].theta) || !std::isfinite(samples[i + 1].theta) ||
        !std::isfinite(steps[i])) {
      throw std::invalid_argument("rate harmonics: sample " + std::to_string(i) +
                                  " or the next is not finite");
    }
    if (steps[i] <= 0.0) {
      throw std::invalid_argument("rate harmonics: time does not grow after sample " +
                                  std::to_string(i));
    }
  }
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

std::size_t windowSamples(double window, double period) {
  const double count = std::round(window / period);
  if (!(count >= 2.0)) {
    throw std::invalid_argument("rate harmonics: a window of " + std::to_string(window) +
                                " s holds under two samples of " + std::to_string(period) + " s");
  }
  return static_cast<std::size_t>(count);
}

bool stepsAre(const std::vector<AngleSample>& samples, std::size_t first, std::size_t second,
              double period) {
  const double steps = static_cast<double>(second - first);
  return std::abs(samples[second].time - samples[first].time - steps * period) < 0.5 * period;
}

std::vector<Window> cutWindows(const std::vector<AngleSample>& samples, std::size_t count,
                               double period) {
  std::vector<Window> windows;
  std::size_t first = 0;
  while (first + count <= samples.size()) {
    if (stepsAre(samples, first, first + count - 1, period)) {
      windows.push_back({first, count});
      first += count;
    } else {
      ++first;
    }
  }
  return windows;
}

double meanTheta(const std::vector<AngleSample>& samples, const Window& window) {
  double sum = 0.0;  // relative to the first angle, so that many turns cost no digits
  for (std::size_t k = 1; k < window.count; ++k) {
    sum += samples[window.first + k].theta - samples[window.first].theta;
  }
  return samples[window.first].theta + sum / static_cast<double>(window.count);
}

// Calls use(earlier, later) for each pair of consecutive windows without a gap.
template <typename Use>
void forEachPair(const std::vector<AngleSample>& samples, const std::vector<Window>& windows,
                 double period, const Use& use) {
  for (std::size_t i = 0; i + 1 < windows.size(); ++i) {
    const std::size_t first = windows[i].first;
    const std::size_t second = windows[i + 1].first;
    if (second - first == windows[i].count && stepsAre(samples, first, second, period)) {
      use(i, i + 1);
    }
  }
}

// The samples of the last whole turns, and how many turns these are.
std::vector<AngleSample> lastWholeTurns(const std::vector<AngleSample>& samples, int& turns) {
  constexpr double kSlack = 1e-9;  // of a turn, for rounding
  const double end = samples.back().theta;
  const double travel = std::abs(end - samples.front().theta) / kTwoPi;
  turns = static_cast<int>(std::floor(travel + kSlack));
  if (turns < 1) {
    throw std::invalid_argument("rate harmonics: the angle made " + std::to_string(travel) +
                                " turns, at least one is needed");
  }
  const double wanted = kTwoPi * (turns - kSlack);
  std::size_t first = samples.size() - 1;
  while (std::abs(end - samples[first].theta) < wanted) --first;
  return {samples.begin() + static_cast<std::ptrdiff_t>(first), samples.end()};
}

double peakToPeak(const RateHarmonics& fit) {
  constexpr int kSteps = 7200;  // relative error for the 8th harmonic: 6e-6 at most
  double lowest = 0.0;
  double highest = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double value = fit.rate(kTwoPi * i / kSteps) - fit.mean_rate;
    lowest = std::min(lowest, value);
    highest = std::max(highest, value);
  }
  return highest - lowest;
}

}  // namespace

double RateHarmonics::amplitude(int harmonic) const {
  return std::hypot(cosine.at(harmonic - 1), sine.at(harmonic - 1));
}

double RateHarmonics::phase(int harmonic) const {
  return std::atan2(sine.at(harmonic - 1), cosine.at(harmonic - 1));
}

double RateHarmonics::rate(double theta) const {
  return coefficients(*this).dot(harmonicTerms(theta));
}

double windowOfTurns(const std::vector<AngleSample>& samples, double period) {
  constexpr double kLongest = 0.1;          // [s]
  constexpr double kWindowsOfATurn = 64.0;  // at least
  const double travel = std::abs(samples.back().theta - samples.front().theta);
  const double time = samples.back().time - samples.front().time;
  const double of_turn = kTwoPi * time / std::max(travel, 1e-9) / kWindowsOfATurn;
  return std::max(2.0 * period, std::min(kLongest, of_turn));
}

RateHarmonics fitRateHarmonics(const std::vector<AngleSample>& all_samples, double window) {
  const double period = samplePeriod(all_samples);
  const std::size_t count = windowSamples(window, period);
  RateHarmonics fit;
  const std::vector<AngleSample> samples = lastWholeTurns(all_samples, fit.whole_turns);
  const std::vector<Window> windows = cutWindows(samples, count, period);

  // Difference of neighbouring means = mean of the rate with triangular weights; trapezoidal rule.
  std::vector<double> means;
  std::vector<Terms> rising;
  std::vector<Terms> falling;
  const double square = static_cast<double>(count) * static_cast<double>(count);
  for (const Window& w : windows) {
    means.push_back(meanTheta(samples, w));
    rising.push_back(Terms::Zero());
    falling.push_back(Terms::Zero());
    for (std::size_t k = 0; k < count; ++k) {
      const Terms terms = harmonicTerms(samples[w.first + k].theta);
      rising.back() += (static_cast<double>(k) + 0.5) / square * terms;
      falling.back() += (static_cast<double>(count - k) - 0.5) / square * terms;
    }
  }
  Eigen::Matrix<double, Eigen::Dynamic, kTerms> design(windows.size(), kTerms);
  Eigen::VectorXd rates(windows.size());
  Eigen::Index rows = 0;
  forEachPair(samples, windows, period, [&](std::size_t earlier, std::size_t later) {
    design.row(rows) = (rising[earlier] + falling[later]).transpose();
    rates(rows) = (means[later] - means[earlier]) / (static_cast<double>(count) * period);
    ++rows;
  });
  if (rows < 2 * kTerms) {
    throw std::invalid_argument("rate harmonics: " + std::to_string(rows) + " windows of " +
                                std::to_string(window) + " s in " +
                                std::to_string(fit.whole_turns) + " turns, at least " +
                                std::to_string(2 * kTerms) + " are needed; shorten the window");
  }
  const auto used_design = design.topRows(rows);
  const auto used_rates = rates.head(rows);
  const Terms solution = used_design.colPivHouseholderQr().solve(used_rates);

  fit.mean_rate = solution(0);
  for (int n = 1; n <= RateHarmonics::kCount; ++n) {
    fit.cosine[n - 1] = solution(n);
    fit.sine[n - 1] = solution(RateHarmonics::kCount + n);
  }
  fit.peak_to_peak = peakToPeak(fit);
  fit.residual_rms =
      (used_rates - used_design * solution).norm() / std::sqrt(static_cast<double>(rows));
  fit.begin_time = samples.front().time;
  fit.end_time = samples.back().time;
  return fit;
}

std::vector<RateSample> windowedRates(const std::vector<AngleSample>& samples, double window) {
  const double period = samplePeriod(samples);
  const std::size_t count = windowSamples(window, period);
  const std::vector<Window> windows = cutWindows(samples, count, period);
  std::vector<RateSample> result;
  forEachPair(samples, windows, period, [&](std::size_t earlier, std::size_t later) {
    const double before = meanTheta(samples, windows[earlier]);
    const double after = meanTheta(samples, windows[later]);
    const double middle =
        0.5 * (samples[windows[later].first - 1].time + samples[windows[later].first].time);
    result.push_back(
        {middle, 0.5 * (before + after), (after - before) / (static_cast<double>(count) * period)});
  });
  return result;
}

}  // namespace cvg
