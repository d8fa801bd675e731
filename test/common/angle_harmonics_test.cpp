#include "ring_gyro/common/angle_harmonics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cvg {
namespace {

TEST(AngleHarmonics, AreTheSumOfTheirOrders) {
  const AngleHarmonics function{0.5, {1.0, -2.0, 0.25}, {0.0, 3.0}};
  for (double theta = -7.0; theta < 7.0; theta += 0.37) {
    const double expected = 0.5 + std::cos(theta) - 2.0 * std::cos(2.0 * theta) +
                            0.25 * std::cos(3.0 * theta) + 3.0 * std::sin(2.0 * theta);
    EXPECT_NEAR(function.at(theta), expected, 1e-14);
    const double step = 1e-5;
    const double slope = (function.at(theta + step) - function.at(theta - step)) / (2.0 * step);
    EXPECT_NEAR(function.slopeAt(theta), slope, 1e-8);
  }
}

TEST(AngleHarmonics, AddUpOrderByOrder) {
  AngleHarmonics sum{0.1, {1.0}, {}};
  sum += AngleHarmonics{0.2, {1.0, 2.0}, {3.0}};
  EXPECT_DOUBLE_EQ(sum.constant, 0.3);
  EXPECT_EQ(sum.cosine, (std::vector<double>{2.0, 2.0}));
  EXPECT_EQ(sum.sine, (std::vector<double>{3.0}));
  EXPECT_EQ(sum.orders(), 2u);
}

}  // namespace
}  // namespace cvg
