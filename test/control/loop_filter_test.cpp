#include "ring_gyro/control/loop_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ring_gyro/common/angle.h"

namespace cvg {
namespace {

constexpr double kPeriod = 1e-3;

// An integrator that the filter drives towards a target; returns the largest overshoot.
double overshoot(double target, double limit, double tuning_damping, double* final_error) {
  LoopFilter filter(loopGains(10.0, tuning_damping), kPeriod, -limit, limit);
  double value = 0.0;
  double largest = 0.0;
  for (int step = 0; step < 5000; ++step) {
    value += kPeriod * filter.update(target - value);
    largest = std::max(largest, (value - target) / target);
  }
  *final_error = target - value;
  return largest;
}

TEST(LoopGains, PlaceThePolesOfTheClosedLoop) {
  const LoopGains gains = loopGains(5.0, 0.7, 3.0);
  const double natural = kTwoPi * 5.0;
  EXPECT_NEAR(gains.integral, natural * natural, 1e-9);
  EXPECT_NEAR(gains.proportional + 3.0, 2.0 * 0.7 * natural, 1e-12);
}

TEST(LoopFilter, DoesNotWindUpInEitherDirection) {
  for (const double sign : {1.0, -1.0}) {
    double error = 0.0;
    const double free = overshoot(sign * 1.0, 1e9, 1.0, &error);
    const double limited = overshoot(sign * 1.0, 1.0, 1.0, &error);  // a second at the limit
    EXPECT_LT(limited, free + 0.01) << "a limit must not add overshoot";
    EXPECT_NEAR(error, 0.0, 1e-9);
  }
}

TEST(LoopFilter, LeavesALimitAtOnceWhenTheErrorTurns) {
  for (const double sign : {1.0, -1.0}) {
    LoopFilter filter({10.0, 100.0}, kPeriod, -1.0, 1.0);
    for (int step = 0; step < 100000; ++step) filter.update(sign * 5.0);
    EXPECT_EQ(filter.update(sign * 5.0), sign * 1.0);
    // Nothing was stored at the limit: 10 * -0.05 and one step of the integral.
    EXPECT_NEAR(filter.update(-sign * 0.05), -sign * 0.505, 1e-12);
  }
}

TEST(LoopFilter, RemovesAConstantDisturbance) {
  LoopFilter filter(loopGains(20.0, 1.0), kPeriod, -100.0, 100.0);
  double value = 0.0;
  for (int step = 0; step < 2000; ++step) value += kPeriod * (filter.update(-value) + 7.0);
  EXPECT_NEAR(value, 0.0, 1e-12);
  EXPECT_NEAR(filter.integral(), -7.0, 1e-9);
}

// What is learnt ahead of the loop must not carry it beyond its limits.
TEST(LoopFilter, LimitsTheSumWithWhatIsAddedToIt) {
  for (const double sign : {1.0, -1.0}) {
    for (const double beside : {0.0, 0.7, 3.0, -0.4}) {
      LoopFilter filter(loopGains(10.0, 1.0), kPeriod, -1.0, 1.0);
      double output = 0.0;
      for (int step = 0; step < 1000; ++step) output = filter.update(sign * 0.5, sign * beside);
      EXPECT_DOUBLE_EQ(output + sign * beside, sign * 1.0);
      // And back at once.
      output = filter.update(-sign * 0.5, sign * beside);
      EXPECT_LT(sign * (output + sign * beside), 1.0);
    }
  }
}

}  // namespace
}  // namespace cvg
