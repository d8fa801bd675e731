#include "ring_gyro/common/vector_kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <random>
#include <vector>

namespace ring_gyro {
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
    std::vector<double> out(kCount);
    samplePhasorSeries(real.data(), imaginary.data(), terms, share.data(), cosine.data(),
                       sine.data(), kCount, out.data());
    for (std::size_t j = 0; j < kCount; ++j) {
      Complex sum = 0.0;
      for (int k = 0; k < terms; ++k) {
        sum += Complex(real[static_cast<std::size_t>(k)], imaginary[static_cast<std::size_t>(k)]) *
               std::pow(share[j], k);
      }
      ASSERT_NEAR(out[j], (sum * std::polar(1.0, turn[j])).real(), 1e-14);
    }
  }
}

TEST(VectorKernels, MixDownTurnsBothAxesBack) {
  const std::vector<double> x = randomNumbers(5);
  const std::vector<double> y = randomNumbers(6);
  std::vector<double> xr(kCount), xi(kCount), yr(kCount), yi(kCount);
  mixDown(x.data(), y.data(), 2.5, 0.44, kCount, xr.data(), xi.data(), yr.data(), yi.data());
  for (std::size_t j = 0; j < kCount; ++j) {
    const Complex turn = std::polar(1.0, -2.5 - 0.44 * static_cast<double>(j));
    ASSERT_NEAR(std::abs(Complex(xr[j], xi[j]) - x[j] * turn), 0.0, 2e-14);
    ASSERT_NEAR(std::abs(Complex(yr[j], yi[j]) - y[j] * turn), 0.0, 2e-14);
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

}  // namespace
}  // namespace ring_gyro
