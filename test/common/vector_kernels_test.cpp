#include "ring_gyro/common/vector_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <random>
#include <vector>

namespace cvg {
namespace {

using Complex = std::complex<double>;
constexpr std::size_t kCount = paddedToLanes(200);

std::vector<double> randomNumbers(unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<double> numbers(kCount);
  for (double& number : numbers) number = unit(random);
  return numbers;
}

TEST(VectorKernels, PaddingIsToWholeLanes) {
  EXPECT_EQ(paddedToLanes(1), kKernelLanes);
  EXPECT_EQ(paddedToLanes(kKernelLanes), kKernelLanes);
  EXPECT_EQ(paddedToLanes(kKernelLanes + 1), 2 * kKernelLanes);
}

TEST(VectorKernels, PhasorSeriesIsItsDefinition) {
  const std::vector<double> real = randomNumbers(1);
  const std::vector<double> imaginary = randomNumbers(2);
  const std::vector<double> share = randomNumbers(3);
  const std::vector<double> turn = randomNumbers(4);
  std::vector<double> cosine;
  std::vector<double> sine;
  for (const double angle : turn) {
    cosine.push_back(std::cos(angle));
    sine.push_back(std::sin(angle));
  }
  for (const int terms : {1, 2, 7}) {
    PhasorSeries series;
    series.terms = terms;
    for (std::size_t k = 0; k < static_cast<std::size_t>(terms); ++k) {
      series.x_real[k] = real[k];
      series.x_imaginary[k] = imaginary[k];
      series.y_real[k] = real[k + 20];
      series.y_imaginary[k] = imaginary[k + 20];
    }
    std::vector<double> x(kCount), y(kCount);
    samplePhasorSeries(series, share.data(), cosine.data(), sine.data(), kCount, x.data(),
                       y.data());
    for (std::size_t j = 0; j < kCount; ++j) {
      Complex sum_x = 0.0;
      Complex sum_y = 0.0;
      for (std::size_t k = 0; k < static_cast<std::size_t>(terms); ++k) {
        const double power = std::pow(share[j], static_cast<double>(k));
        sum_x += Complex(real[k], imaginary[k]) * power;
        sum_y += Complex(real[k + 20], imaginary[k + 20]) * power;
      }
      ASSERT_NEAR(x[j], (sum_x * std::polar(1.0, turn[j])).real(), 1e-14);
      ASSERT_NEAR(y[j], (sum_y * std::polar(1.0, turn[j])).real(), 1e-14);
    }
  }
}

TEST(VectorKernels, MixDownTurnsBothAxesBackAndWeighsThem) {
  const std::vector<double> x = randomNumbers(5);
  const std::vector<double> y = randomNumbers(6);
  const std::vector<double> weights = randomNumbers(14);
  for (const std::size_t count : {kCount, std::size_t{200}, std::size_t{3}}) {
    std::vector<double> xr(kCount, 9.0), xi(kCount, 9.0), yr(kCount, 9.0), yi(kCount, 9.0);
    double sums[4];
    mixDown(x.data(), y.data(), 2.5, 0.44, count, weights.data(), 0, xr.data(), xi.data(),
            yr.data(), yi.data(), sums);
    Complex sum_x = 0.0;
    Complex sum_y = 0.0;
    for (std::size_t j = 0; j < count; ++j) {
      const Complex turn = std::polar(1.0, -2.5 - 0.44 * static_cast<double>(j));
      ASSERT_NEAR(std::abs(Complex(xr[j], xi[j]) - x[j] * turn), 0.0, 2e-14);
      ASSERT_NEAR(std::abs(Complex(yr[j], yi[j]) - y[j] * turn), 0.0, 2e-14);
      sum_x += weights[j] * x[j] * turn;
      sum_y += weights[j] * y[j] * turn;
    }
    for (std::size_t j = count; j < paddedToLanes(count); ++j) ASSERT_EQ(xr[j], 0.0);
    EXPECT_NEAR(std::abs(Complex(sums[0], sums[1]) - sum_x), 0.0, 1e-13);
    EXPECT_NEAR(std::abs(Complex(sums[2], sums[3]) - sum_y), 0.0, 1e-13);
  }
}

TEST(VectorKernels, PhasorIsAddedAtEachStep) {
  std::vector<double> out = randomNumbers(9);
  const std::vector<double> before = out;
  addPhasor(0.3, -1.2, 0.44, kCount, out.data());
  for (std::size_t j = 0; j < kCount; ++j) {
    const Complex turned = Complex(0.3, -1.2) * std::polar(1.0, 0.44 * static_cast<double>(j));
    ASSERT_NEAR(out[j] - before[j], turned.real(), 2e-14);
  }
}

TEST(VectorKernels, QuantiseRoundsAndCountsWhatLiesBeyond) {
  std::vector<double> values = randomNumbers(10);
  const std::vector<double> before = values;
  const double step = 1.0 / 64.0;
  std::size_t beyond = 0;
  quantise(step, -0.5, 0.5 - step, kCount, values.data());
  for (std::size_t j = 0; j < kCount; ++j) {
    const double level = std::nearbyint(before[j] / step) * step;
    if (level < -0.5 || level > 0.5 - step) ++beyond;
    ASSERT_EQ(values[j], std::min(std::max(level, -0.5), 0.5 - step));
  }
  values = before;
  EXPECT_EQ(quantise(step, -0.5, 0.5 - step, kCount, values.data()), beyond);
  EXPECT_GT(beyond, 50u);
}

TEST(VectorKernels, RecurrenceIsItsDefinition) {
  const std::vector<double> numbers = randomNumbers(11);
  const std::vector<double> p = randomNumbers(12);
  const std::vector<double> q = randomNumbers(13);
  LinearRecurrence recurrence;
  for (std::size_t k = 0; k < 16; ++k) recurrence.flow[k] = 0.4 * numbers[k];
  for (std::size_t k = 0; k < 8; ++k) recurrence.input[k] = numbers[16 + k];
  for (std::size_t k = 0; k < 4; ++k) recurrence.output[k] = numbers[24 + k];
  for (const std::size_t count : {kCount, kCount - 1, std::size_t{1}}) {
    double state[4] = {1.0, -2.0, 0.5, 0.25};
    double expected[4] = {1.0, -2.0, 0.5, 0.25};
    std::vector<double> first(kCount), second(kCount);
    runRecurrence(recurrence, state, p.data(), q.data(), count, first.data(), second.data());
    const double* out = recurrence.output;
    for (std::size_t j = 0; j < count; ++j) {
      ASSERT_NEAR(first[j], out[0] * expected[0] + out[2] * expected[2], 1e-13);
      ASSERT_NEAR(second[j], out[1] * expected[1] + out[3] * expected[3], 1e-13);
      double next[4];
      for (std::size_t row = 0; row < 4; ++row) {
        next[row] = recurrence.input[row] * p[j] + recurrence.input[4 + row] * q[j];
        for (std::size_t k = 0; k < 4; ++k) next[row] += recurrence.flow[4 * k + row] * expected[k];
      }
      std::copy(next, next + 4, expected);
    }
    for (std::size_t row = 0; row < 4; ++row) EXPECT_NEAR(state[row], expected[row], 1e-13);
  }
}

TEST(VectorKernels, WeightedSumIsTheScalarProduct) {
  const std::vector<double> weights = randomNumbers(7);
  const std::vector<double> values = randomNumbers(8);
  long double sum = 0.0L;
  for (std::size_t j = 0; j < kCount; ++j) {
    sum += static_cast<long double>(weights[j]) * values[j];
  }
  EXPECT_NEAR(weightedSum(weights.data(), values.data(), kCount), static_cast<double>(sum), 1e-14);
}

TEST(VectorKernels, SumTakesAnyCountAndShowsWhatIsNotFinite) {
  std::vector<double> values = randomNumbers(15);
  for (const std::size_t count : {std::size_t{1}, std::size_t{200}, kCount}) {
    long double sum = 0.0L;
    for (std::size_t j = 0; j < count; ++j) sum += values[j];
    EXPECT_NEAR(sumOf(values.data(), count), static_cast<double>(sum), 1e-13);
  }
  values[199] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(std::isfinite(sumOf(values.data(), 200)));
  EXPECT_TRUE(std::isfinite(sumOf(values.data(), 199)));
}

}  // namespace
}  // namespace cvg
