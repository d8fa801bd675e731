#include "ring_gyro/common/angle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace cvg {
namespace {

TEST(WrapToPi, IsTheRemainderToTheLastBit) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const double size : {1.0, 10.0, 100.0, 1e4, 9e5, 1e9}) {
    for (int n = 0; n < 200000; ++n) {
      const double angle = size * unit(random);
      ASSERT_EQ(wrapToPi(angle), std::remainder(angle, kTwoPi)) << angle;
    }
  }
}

TEST(WrapToPi, KeepsItsSideAtHalfTurns) {
  for (int turns = -1000; turns <= 1000; ++turns) {
    for (double angle = std::nextafter(turns * kPi, -1e9); angle <= turns * kPi + 1e-9;
         angle = std::nextafter(angle + 2e-10, 1e9)) {
      ASSERT_EQ(wrapToPi(angle), std::remainder(angle, kTwoPi)) << angle;
    }
    ASSERT_EQ(wrapToPi(turns * kPi), std::remainder(turns * kPi, kTwoPi)) << turns;
  }
}

TEST(WrapToPi, OfWhatIsNotFiniteIsNotANumber) {
  EXPECT_TRUE(std::isnan(wrapToPi(std::numeric_limits<double>::infinity())));
  EXPECT_TRUE(std::isnan(wrapToPi(std::numeric_limits<double>::quiet_NaN())));
}

}  // namespace
}  // namespace cvg
