#include "ring_gyro/identification/factored_covariance.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "ring_gyro/common/sine_cosine.h"

namespace ring_gyro {
namespace {

using Matrix7 = Eigen::Matrix<double, 7, 7>;
using Vector7 = Eigen::Matrix<double, 7, 1>;

Vector7 someVariances() {
  Vector7 variance;
  variance << 0.7, 0.3, 1e-3, 2e-3, 1e-9, 3e-9, 1e8;
  return variance;
}

FactoredCovariance<2>::Map<2> someMap() {
  FactoredCovariance<2>::Map<2> map;
  map << 0.9, 0.2, 3.0, -4.0, 2e3, 1e3, 2e-5,  //
      -0.1, 1.1, 1.0, 5.0, -4e3, 2e3, -1e-5;
  return map;
}

Eigen::Matrix2d someNoise() {
  Eigen::Matrix2d noise;
  noise << 0.05, 0.02, 0.02, 0.04;
  return noise;
}

Matrix7 transitionOf(const FactoredCovariance<2>::Map<2>& map) {
  Matrix7 transition = Matrix7::Identity();
  transition.topRows<2>() = map;
  return transition;
}

/// Relative to the standard deviations.
double difference(const Matrix7& covariance, const Matrix7& expected) {
  const Vector7 scale = expected.diagonal().cwiseSqrt().cwiseInverse();
  return (scale.asDiagonal() * (covariance - expected) * scale.asDiagonal()).cwiseAbs().maxCoeff();
}

TEST(FactoredCovariance, PropagatesAndMeasuresAsFullMatricesDo) {
  FactoredCovariance<2> factored(someVariances());
  Matrix7 full = someVariances().asDiagonal();
  for (int n = 0; n < 5; ++n) {
    FactoredCovariance<2> next;
    factored.propagate<2>(someMap(), someNoise(), next);
    full = (transitionOf(someMap()) * full * transitionOf(someMap()).transpose()).eval();
    full.topLeftCorner<2, 2>() += someNoise();
    ASSERT_LT(difference(next.matrix(), full), 1e-13);

    const auto a = next.measure<0>(0.01);
    EXPECT_NEAR(a.variance, full(0, 0) + 0.01, 1e-12 * a.variance);
    EXPECT_NEAR(a.cross[1], full(0, 1), 1e-12 * std::sqrt(full(0, 0) * full(1, 1)));
    full -= (full.col(0) * full.row(0) / (full(0, 0) + 0.01)).eval();
    ASSERT_LT(difference(next.matrix(), full), 1e-12);
    const auto b = next.measure<1>(0.02);
    EXPECT_NEAR(b.variance, full(1, 1) + 0.02, 1e-12 * b.variance);
    full -= (full.col(1) * full.row(1) / (full(1, 1) + 0.02)).eval();
    ASSERT_LT(difference(next.matrix(), full), 1e-11);
    EXPECT_NEAR(next.variance(4), full(4, 4), 1e-11 * full(4, 4));
    factored = next;
  }
}

TEST(FactoredCovariance, TakesTheMeanInAndDropsIt) {
  // The first two new states are those of the last two, measured with their own noise.
  const FactoredCovariance<2> start(someVariances());
  FactoredCovariance<2>::Map<4> map;
  map << someMap(), someMap();
  Eigen::Matrix4d noise;
  noise << someNoise(), someNoise(), someNoise(), someNoise();
  FactoredCovariance<4> four;
  start.propagate<4>(map, noise, four);
  FactoredCovariance<2> two;
  start.propagate<2>(someMap(), someNoise(), two);
  EXPECT_LT(difference(four.without<2>().matrix(), two.matrix()), 1e-13);
  four.measure<0>(0.01);
  four.measure<1>(0.01);
  two.measure<0>(0.01);
  two.measure<1>(0.01);
  EXPECT_LT(difference(four.without<2>().matrix(), two.matrix()), 1e-12);
}

TEST(FactoredCovariance, AddsVarianceToConstants) {
  FactoredCovariance<2> factored;
  FactoredCovariance<2>(someVariances()).propagate<2>(someMap(), someNoise(), factored);
  Matrix7 full = factored.matrix();
  Eigen::Matrix<double, 5, 1> added;
  added << 1e-4, 0.0, 1e-10, 2e-9, 1e6;
  factored.addToConstants(added);
  full.diagonal().tail<5>() += added;
  EXPECT_LT(difference(factored.matrix(), full), 1e-13);
}

// A full matrix has lost the sign of the smallest variance long before.
TEST(FactoredCovariance, StaysPositiveHoweverPreciseTheMeasurement) {
  FactoredCovariance<2> factored(someVariances());
  for (int n = 0; n < 100; ++n) {
    FactoredCovariance<2> next;
    factored.propagate<2>(someMap(), 1e-20 * someNoise(), next);
    next.measure<0>(1e-24);
    next.measure<1>(1e-24);
    factored = next;
    ASSERT_TRUE(factored.isFinite());
    for (int k = 0; k < 7; ++k) ASSERT_GT(factored.variance(k), 0.0) << n << " " << k;
  }
}

TEST(SineCosine, AgreesWithTheLibrary) {
  for (const double scale : {1.0, 100.0, 1e4, 9.9e5, 1e9}) {
    for (int n = -2000; n <= 2000; ++n) {
      const double angle = scale * n / 2000.0;
      const SineCosine<2> result = sineCosine<2>({angle, 0.3 - angle});
      EXPECT_NEAR(result.sine[0], std::sin(angle), 2.3e-16) << angle;
      EXPECT_NEAR(result.cosine[0], std::cos(angle), 2.3e-16) << angle;
      EXPECT_NEAR(result.sine[1], std::sin(0.3 - angle), 2.3e-16) << angle;
      EXPECT_NEAR(result.cosine[1], std::cos(0.3 - angle), 2.3e-16) << angle;
    }
  }
}

}  // namespace
}  // namespace ring_gyro
