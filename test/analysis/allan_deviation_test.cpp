#include "ring_gyro/analysis/allan_deviation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

namespace cvg {
namespace {

constexpr double kPeriod = 1e-3;
constexpr std::size_t kCount = 100'000;

TEST(AllanDeviation, ofWhiteAngleNoise) {
  std::mt19937_64 engine(1);
  std::normal_distribution<double> noise(0.0, 1e-4);
  std::vector<double> angles(kCount);
  for (double& angle : angles) angle = noise(engine);
  for (const AllanPoint& point : allanDeviation(angles, kPeriod)) {
    if (point.relative_sigma > 0.05) break;
    EXPECT_NEAR(point.deviation * point.time / (std::sqrt(3.0) * 1e-4), 1.0,
                0.02 + 4.0 * point.relative_sigma)
        << point.time;
  }
}

TEST(AllanDeviation, ofWhiteRateNoise) {
  std::mt19937_64 engine(2);
  const double walk = 2e-3;  // rad/sqrt(s)
  std::normal_distribution<double> noise(0.0, walk * std::sqrt(kPeriod));
  std::vector<double> angles(kCount);
  double angle = 0.0;
  for (double& value : angles) value = angle += noise(engine);
  for (const AllanPoint& point : allanDeviation(angles, kPeriod)) {
    if (point.relative_sigma > 0.05) break;
    EXPECT_NEAR(point.deviation * std::sqrt(point.time) / walk, 1.0,
                0.02 + 4.0 * point.relative_sigma)
        << point.time;
  }
}

TEST(AllanDeviation, ofARampOfTheRate) {
  std::vector<double> angles(3000);
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const double time = kPeriod * static_cast<double>(i);
    angles[i] = 0.5 * 0.3 * time * time + 5.0 * time - 2.0;
  }
  const auto points = allanDeviation(angles, kPeriod, 1);
  ASSERT_EQ(points.size(), 10u);  // m = 1, 2, 4 .. 512
  for (const AllanPoint& point : points) {
    EXPECT_NEAR(point.deviation, 0.3 * point.time / std::sqrt(2.0), 1e-6);
  }
}

TEST(AllanDeviation, refusesAndIsEmpty) {
  EXPECT_TRUE(allanDeviation({1.0, 2.0}, kPeriod).empty());
  EXPECT_THROW(allanDeviation({1.0, 2.0, 3.0}, 0.0), std::invalid_argument);
  EXPECT_THROW(allanDeviation({1.0, 2.0, std::numeric_limits<double>::quiet_NaN()}, kPeriod),
               std::invalid_argument);
}

TEST(AngleResidual, ofARateThatDependsOnTheAngleIsNothing) {
  RateHarmonics fit;
  fit.mean_rate = -0.2;
  fit.cosine[1] = 0.05;
  fit.sine[3] = 0.01;
  std::vector<AngleSample> samples;
  double theta = 0.4;
  for (int i = 0; i < 20'000; ++i) {
    samples.push_back({kPeriod * i, theta});
    const double middle = theta + 0.5 * kPeriod * fit.rate(theta);
    theta += kPeriod * fit.rate(middle);
  }
  const std::vector<double> residual = angleResidual(samples, {0, samples.size()}, fit);
  ASSERT_EQ(residual.size(), samples.size());
  for (double value : residual) EXPECT_NEAR(value, 0.0, 1e-8);
}

TEST(LongestStretch, isBetweenGaps) {
  std::vector<AngleSample> samples;
  for (int i = 0; i < 100; ++i) {
    if (i != 30 && i != 90) samples.push_back({kPeriod * i, 0.0});
  }
  const SampleStretch stretch = longestStretch(samples, kPeriod);
  EXPECT_EQ(stretch.first, 30u);
  EXPECT_EQ(stretch.end, 89u);
  EXPECT_EQ(longestStretch({}, kPeriod).end, 0u);
}

}  // namespace
}  // namespace cvg
