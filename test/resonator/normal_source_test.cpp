#include "ring_gyro/resonator/normal_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace cvg {
namespace {

std::vector<double> drawn(std::uint64_t seed, std::size_t count) {
  NormalSource source(seed);
  std::vector<double> numbers(count, 0.0);
  source.addTo(numbers.data(), count, 1.0);
  return numbers;
}

TEST(NormalSource, IsAStreamThatItsSeedFixes) {
  const std::vector<double> numbers = drawn(9, 1000);
  EXPECT_EQ(numbers, drawn(9, 1000));
  EXPECT_NE(numbers, drawn(10, 1000));
  NormalSource source(9);
  for (const double number : numbers) ASSERT_EQ(source.next(), number);
}

TEST(NormalSource, HasTheMomentsOfTheNormalDistribution) {
  const std::size_t count = 4000000;
  double sums[5] = {};
  for (const double number : drawn(1, count)) {
    double power = 1.0;
    for (double& sum : sums) sum += (power *= number);
  }
  const double n = static_cast<double>(count);
  // Moments 0, 1, 0, 3, 0 within four standard deviations, sqrt((2k-1)!! / n).
  EXPECT_NEAR(sums[0] / n, 0.0, 4.0 * std::sqrt(1.0 / n));
  EXPECT_NEAR(sums[1] / n, 1.0, 4.0 * std::sqrt(2.0 / n));
  EXPECT_NEAR(sums[2] / n, 0.0, 4.0 * std::sqrt(15.0 / n));
  EXPECT_NEAR(sums[3] / n, 3.0, 4.0 * std::sqrt(96.0 / n));
  EXPECT_NEAR(sums[4] / n, 0.0, 4.0 * std::sqrt(945.0 / n));
}

// Kolmogorov-Smirnov: the largest gap between the distribution and the numbers'.
TEST(NormalSource, FollowsTheDistributionIntoTheTails) {
  std::vector<double> numbers = drawn(2, 1000000);
  std::sort(numbers.begin(), numbers.end());
  const double n = static_cast<double>(numbers.size());
  double gap = 0.0;
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const double expected = 0.5 * std::erfc(-numbers[k] / std::sqrt(2.0));
    gap = std::max(gap, std::abs(expected - (static_cast<double>(k) + 0.5) / n));
  }
  EXPECT_LT(gap * std::sqrt(n), 1.63);  // 1 % level
  EXPECT_GT(numbers.back(), 4.3);
  EXPECT_LT(numbers.back(), 6.5);
}

TEST(NormalSource, NeighboursAndLanesAreIndependent) {
  const std::vector<double> numbers = drawn(3, 2000000);
  for (const std::size_t lag : {1u, 2u, 7u, 8u, 9u, 16u, 32u}) {
    double sum = 0.0;
    double squares = 0.0;
    for (std::size_t k = lag; k < numbers.size(); ++k) {
      sum += numbers[k] * numbers[k - lag];
      squares += (numbers[k] * numbers[k] - 1.0) * (numbers[k - lag] * numbers[k - lag] - 1.0);
    }
    const double n = static_cast<double>(numbers.size() - lag);
    EXPECT_LT(std::abs(sum / n), 4.5 / std::sqrt(n)) << lag;
    EXPECT_LT(std::abs(squares / n), 4.5 * 2.0 / std::sqrt(n)) << lag;
  }
}

}  // namespace
}  // namespace cvg
