#include "ring_gyro/calibration/rate_parity.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "ring_gyro/common/angle.h"

namespace cvg {
namespace {

constexpr int kGrid = 1440;  // angles per turn; relative error for the 8th harmonic: 2e-4

double gridAngle(int index) { return kTwoPi * index / kGrid; }

AngleHarmonics combined(const RateHarmonics& forward, const RateHarmonics& backward, double sign) {
  AngleHarmonics result;
  result.constant = 0.5 * (forward.mean_rate + sign * backward.mean_rate);
  for (int i = 0; i < RateHarmonics::kCount; ++i) {
    result.cosine.push_back(0.5 * (forward.cosine[i] + sign * backward.cosine[i]));
    result.sine.push_back(0.5 * (forward.sine[i] + sign * backward.sine[i]));
  }
  return result;
}

/// Time that the pattern needs per radian, on the grid [s/rad].
std::vector<double> slowness(const AngleHarmonics& rate) {
  std::vector<double> values(kGrid);
  for (int i = 0; i < kGrid; ++i) {
    const double here = rate.at(gridAngle(i));
    if (!(here * rate.constant > 0.0)) {
      throw std::invalid_argument(
          "calibration: the pattern does not turn one way through the whole angle; turn the table "
          "faster");
    }
    values[i] = 1.0 / here;
  }
  return values;
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

}  // namespace

AngleHarmonics evenPart(const RateHarmonics& forward, const RateHarmonics& backward) {
  return combined(forward, backward, 1.0);
}

AngleHarmonics oddPart(const RateHarmonics& forward, const RateHarmonics& backward) {
  return combined(forward, backward, -1.0);
}

double peakToPeak(const AngleHarmonics& function) {
  double lowest = function.at(0.0);
  double highest = lowest;
  for (int i = 1; i < kGrid; ++i) {
    const double value = function.at(gridAngle(i));
    lowest = std::min(lowest, value);
    highest = std::max(highest, value);
  }
  return highest - lowest;
}

Extreme largestMagnitude(const AngleHarmonics& function) {
  Extreme extreme{0.0, function.at(0.0)};
  for (int i = 1; i < kGrid; ++i) {
    const double value = function.at(gridAngle(i));
    if (std::abs(value) > std::abs(extreme.value)) extreme = {gridAngle(i), value};
  }
  return extreme;
}

AngleHarmonics angleMapOf(const AngleHarmonics& odd_rate, int orders) {
  const std::vector<double> slow = slowness(odd_rate);
  const double mean_slow = mean(slow);
  AngleHarmonics map;
  for (int n = 1; n <= orders; ++n) {
    double cosine = 0.0;
    double sine = 0.0;
    for (int i = 0; i < kGrid; ++i) {
      const double slope = slow[i] / mean_slow - 1.0;
      cosine += slope * std::cos(n * gridAngle(i));
      sine += slope * std::sin(n * gridAngle(i));
    }
    map.cosine.push_back(-2.0 / kGrid * sine / n);
    map.sine.push_back(2.0 / kGrid * cosine / n);
  }
  return map;
}

double angularGainOf(const AngleHarmonics& odd_rate, double rotation_rate) {
  return -1.0 / (mean(slowness(odd_rate)) * rotation_rate);
}

}  // namespace cvg
