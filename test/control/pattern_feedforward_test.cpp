#include "ring_gyro/control/pattern_feedforward.h"

#include <gtest/gtest.h>

#include "ring_gyro/common/angle.h"

namespace cvg {
namespace {

constexpr double kPeriod = 1e-3;

double swing(double theta) { return 3.0 - 2.0 * std::cos(2.0 * theta) + std::sin(2.0 * theta); }

TEST(PatternFeedforward, TakesOverWhatALoopDoesAtEachAngle) {
  for (const double rate : {toRadians(12.0), -toRadians(40.0)}) {
    PatternFeedforward feedforward(0.3, kPeriod);
    double theta = 0.3;
    // A loop that is faster than the learning does whatever the feedforward leaves.
    for (double time = 0.0; time < 300.0; time += kPeriod, theta += rate * kPeriod) {
      feedforward.learn(swing(theta) - feedforward.at(theta), theta);
    }
    for (double angle = 0.0; angle < kPi; angle += 0.1) {
      EXPECT_NEAR(feedforward.at(angle), swing(angle), 1e-6);
    }
  }
}

TEST(PatternFeedforward, DoesNotRunAwayAtRest) {
  PatternFeedforward feedforward(0.3, kPeriod);
  for (double time = 0.0; time < 100.0; time += kPeriod) {
    feedforward.learn(swing(0.7) - feedforward.at(0.7), 0.7);
  }
  EXPECT_NEAR(feedforward.at(0.7), swing(0.7), 1e-9);
  EXPECT_LT(std::abs(feedforward.at(0.7 + 0.25 * kPi)), 10.0);
}

TEST(PatternFeedforward, IsOffAtRateZero) {
  PatternFeedforward feedforward(0.0, kPeriod);
  feedforward.addConstant(2.0);
  feedforward.learn(5.0, 1.0);
  EXPECT_EQ(feedforward.at(0.4), 2.0);
}

}  // namespace
}  // namespace cvg
