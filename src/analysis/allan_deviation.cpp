#include "ring_gyro/analysis/allan_deviation.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace cvg {
namespace {

double deviationAt(const std::vector<double>& angles, std::size_t step, double time) {
  const std::size_t terms = angles.size() - 2 * step;
  double sum = 0.0;
  for (std::size_t k = 0; k < terms; ++k) {
    const double second = angles[k + 2 * step] - 2.0 * angles[k + step] + angles[k];
    sum += second * second;
  }
  return std::sqrt(0.5 * sum / static_cast<double>(terms)) / time;
}

}  // namespace

std::vector<AllanPoint> allanDeviation(const std::vector<double>& angles, double period,
                                       int points_per_octave) {
  if (!(period > 0.0) || points_per_octave < 1) {
    throw std::invalid_argument("Allan deviation: the period must be above zero");
  }
  if (!std::all_of(angles.begin(), angles.end(), [](double x) { return std::isfinite(x); })) {
    throw std::invalid_argument("Allan deviation: an angle is not finite");
  }
  std::vector<AllanPoint> points;
  std::size_t last = 0;
  for (int i = 0;; ++i) {
    const auto step = static_cast<std::size_t>(
        std::llround(std::exp2(static_cast<double>(i) / points_per_octave)));
    if (3 * step > angles.size()) return points;
    if (step == last) continue;
    last = step;
    const double time = static_cast<double>(step) * period;
    const double averages = static_cast<double>(angles.size() - 1) / static_cast<double>(step);
    points.push_back({time, deviationAt(angles, step, time),
                      1.0 / std::sqrt(2.0 * std::max(averages - 1.0, 1.0))});
  }
}

SampleStretch longestStretch(const std::vector<AngleSample>& samples, double period) {
  SampleStretch best;
  std::size_t first = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (i > 0 && std::abs(samples[i].time - samples[i - 1].time - period) > 0.5 * period) first = i;
    if (i + 1 - first > best.end - best.first) best = {first, i + 1};
  }
  return best;
}

std::vector<double> angleResidual(const std::vector<AngleSample>& samples,
                                  const SampleStretch& stretch, const RateHarmonics& fit) {
  std::vector<double> residual;
  residual.reserve(stretch.end - stretch.first);
  double expected = 0.0;
  double rate_before = 0.0;
  for (std::size_t i = stretch.first; i < stretch.end; ++i) {
    const double rate = fit.rate(samples[i].theta);
    if (i > stretch.first) {
      expected += 0.5 * (rate_before + rate) * (samples[i].time - samples[i - 1].time);
    }
    rate_before = rate;
    residual.push_back(samples[i].theta - samples[stretch.first].theta - expected);
  }
  return residual;
}

}  // namespace cvg
