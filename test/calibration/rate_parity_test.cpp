#include "ring_gyro/calibration/rate_parity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "ring_gyro/common/angle.h"

namespace cvg {
namespace {

TEST(RateParity, TellsDriftFromAngleScale) {
  RateHarmonics forward;
  RateHarmonics backward;
  forward.mean_rate = -1.0 + 0.01;
  backward.mean_rate = 1.0 + 0.01;
  forward.cosine[1] = -0.02 + 0.003;
  backward.cosine[1] = 0.02 + 0.003;
  forward.sine[3] = backward.sine[3] = -0.004;
  const AngleHarmonics even = evenPart(forward, backward);
  EXPECT_NEAR(even.constant, 0.01, 1e-16);
  EXPECT_NEAR(even.cosine[1], 0.003, 1e-16);
  EXPECT_NEAR(even.sine[3], -0.004, 1e-16);
  const AngleHarmonics odd = oddPart(forward, backward);
  EXPECT_NEAR(odd.constant, -1.0, 1e-16);
  EXPECT_NEAR(odd.cosine[1], -0.02, 1e-16);
  EXPECT_NEAR(odd.sine[3], 0.0, 1e-16);
}

TEST(RateParity, FindsTheExtremes) {
  const AngleHarmonics function{-0.5, {0.0, 1.0}, {}};
  EXPECT_NEAR(peakToPeak(function), 2.0, 1e-4);
  EXPECT_NEAR(largestMagnitude(function).value, -1.5, 1e-4);
  EXPECT_NEAR(std::cos(2.0 * largestMagnitude(function).theta), -1.0, 1e-4);
}

// A pick-off that shows theta = true + e(true), a case that turns evenly.
TEST(RateParity, MapsAMeasuredAngleToOneThatTurnsEvenly) {
  const double rate = -0.7;
  const double gain = 0.9;
  const auto measured = [](double truth) {
    return truth + 0.004 * std::sin(2.0 * truth + 0.3) - 0.001 * std::cos(4.0 * truth);
  };
  // Rate of the measured angle as harmonics of the measured angle, by their means over a turn.
  constexpr int kSteps = 20000;
  AngleHarmonics odd;
  odd.cosine.assign(8, 0.0);
  odd.sine.assign(8, 0.0);
  for (int i = 0; i < kSteps; ++i) {
    const double truth = kTwoPi * i / kSteps;
    const double step = 1e-5;
    const double slope = (measured(truth + step) - measured(truth - step)) / (2.0 * step);
    const double weight = slope * slope * gain * rate / kSteps;  // the rate, times d theta
    odd.constant += weight;
    for (int n = 1; n <= 8; ++n) {
      odd.cosine[n - 1] += 2.0 * weight * std::cos(n * measured(truth));
      odd.sine[n - 1] += 2.0 * weight * std::sin(n * measured(truth));
    }
  }
  const AngleHarmonics map = angleMapOf(odd, 8);
  double offset = 0.0;
  for (int i = 0; i < 100; ++i) {
    const double truth = kTwoPi * i / 100;
    const double error = measured(truth) + map.at(measured(truth)) - truth;
    if (i == 0) offset = error;
    EXPECT_NEAR(error, offset, 1e-7) << truth;
  }
  EXPECT_NEAR(angularGainOf(odd, -rate), gain, 1e-7);
}

TEST(RateParity, RefusesAPatternThatTurnsBack) {
  const AngleHarmonics odd{1.0, {0.0, 2.0}, {}};
  EXPECT_THROW(angleMapOf(odd, 8), std::invalid_argument);
}

}  // namespace
}  // namespace cvg
