#include "ring_gyro/logs/row_clock.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace cvg {
namespace {

std::vector<double> times(double period, double resolution, int rows) {
  std::vector<double> result;
  for (int k = 0; k < rows; ++k) {
    const double t = 3.0 + period * k;
    result.push_back(resolution > 0.0 ? resolution * std::round(t / resolution) : t);
  }
  return result;
}

TEST(SamplingPeriod, IsExactForWholeRatesAndMicroseconds) {
  EXPECT_EQ(samplingPeriod(times(1e-3, 0.0, 1000)), 1e-3);
  EXPECT_EQ(samplingPeriod(times(1.0 / 3000.0, 0.0, 1000)), 1.0 / 3000.0);
}

TEST(SamplingPeriod, SeesThroughCoarseRounding) {
  EXPECT_NEAR(samplingPeriod(times(1.0 / 3000.0, 1e-4, 2000)), 1.0 / 3000.0, 1e-10);
}

TEST(SamplingPeriod, PassesGapsOver) {
  std::vector<double> t = times(2e-3, 0.0, 1000);
  for (std::size_t k = 500; k < t.size(); ++k) t[k] += 0.77;
  EXPECT_EQ(samplingPeriod(t), 2e-3);
}

TEST(SamplingPeriod, LeavesOddPeriodsAlone) {
  EXPECT_NEAR(samplingPeriod(times(1.2345678e-3, 0.0, 1000)), 1.2345678e-3, 1e-15);
}

TEST(SamplingPeriod, NeedsTimeThatGrows) {
  EXPECT_THROW(samplingPeriod({1.0, 1.0, 1.0}), std::invalid_argument);
}

TEST(RowClock, CountsPeriodsThroughJitterDriftAndGaps) {
  RowClock clock(1e-3);
  std::int64_t index = 0;
  for (int k = 0; k < 100000; ++k) {
    const int row = k + (k >= 50000 ? 250 : 0);
    const double jitter = 0.3e-3 * std::sin(7.0 * k);
    index += clock.step(row * 1e-3 * (1.0 + 2e-5) + jitter);
    ASSERT_EQ(index, row);
  }
}

TEST(RowClock, RefusesTimeThatStaysOrFallsBack) {
  RowClock clock(1e-3);
  EXPECT_EQ(clock.step(1.0), 0);
  EXPECT_THROW(clock.step(1.0), std::invalid_argument);
  EXPECT_THROW(clock.step(0.5), std::invalid_argument);
  EXPECT_THROW(clock.step(1.0003), std::invalid_argument);
  EXPECT_EQ(clock.step(1.001), 1);
}

}  // namespace
}  // namespace cvg
