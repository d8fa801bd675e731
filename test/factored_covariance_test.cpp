#include "ring_gyro/identification/factored_covariance.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

namespace ring_gyro {
namespace {

using Vector = FactoredCovariance::Vector;
using Matrix = FactoredCovariance::Matrix;
using Numbers = FactoredCovariance::Numbers;

Vector someVariances() {
  Vector variance;
  variance << 1e-3, 2e-3, 1e-9, 3e-9, 1e8;
  return variance;
}

constexpr Numbers kFirstRow = {3.0, -4.0, 2e3, 1e3, 2e-5};
constexpr Numbers kSecondRow = {1.0, 5.0, -4e3, 2e3, -1e-5};

Eigen::Map<const Vector> vectorOf(const Numbers& numbers) {
  return Eigen::Map<const Vector>(numbers.data());
}

/// Relative to the standard deviations.
template <typename Full>
double difference(const Full& covariance, const Full& expected) {
  const auto scale = expected.diagonal().cwiseSqrt().cwiseInverse().eval();
  return (scale.asDiagonal() * (covariance - expected) * scale.asDiagonal()).cwiseAbs().maxCoeff();
}

TEST(FactoredCovariance, MeasuresAsFullMatricesDo) {
  FactoredCovariance factored(someVariances());
  Matrix full = someVariances().asDiagonal();
  for (int n = 0; n < 5; ++n) {
    Numbers first_row = kFirstRow;
    first_row[static_cast<std::size_t>(n)] *= 1.7;  // other directions each time
    FactoredCovariance next;
    const FactoredCovariance::Outcome outcome =
        factored.measure(first_row, kSecondRow, 0.01, 0.02, 0.3, -0.2, next);

    const Vector first = vectorOf(first_row);
    const Vector second = vectorOf(kSecondRow);
    const double variance = first.dot(full * first) + 0.01;
    const double common = second.dot(full * first);
    Vector gained = full * first * (0.3 / variance);
    const double left = -0.2 - second.dot(gained);
    full -= (full * first * first.transpose() * full / variance).eval();
    const double second_variance = second.dot(full * second) + 0.02;
    gained += full * second * (left / second_variance);
    full -= (full * second * second.transpose() * full / second_variance).eval();

    EXPECT_NEAR(outcome.first_variance, variance, 1e-12 * variance);
    EXPECT_NEAR(outcome.common, common, 1e-11 * variance);
    EXPECT_NEAR(outcome.second_variance, second_variance, 1e-10 * second_variance);
    EXPECT_NEAR(outcome.first_share, 0.3 / variance, 1e-11 / variance);
    EXPECT_NEAR(outcome.second_innovation, left, 1e-11);
    ASSERT_LT(difference<Matrix>(next.matrix(), full), 1e-10) << n;
    for (int k = 0; k < 5; ++k) {
      EXPECT_NEAR(outcome.gained[static_cast<std::size_t>(k)], gained[k],
                  1e-10 * std::sqrt(full(k, k)))
          << n << " " << k;
      EXPECT_NEAR(next.variance()[k], full(k, k), 1e-10 * full(k, k));
    }
    factored = next;
  }
}

// The two dependent quantities and the five parameters as one full matrix: noise is added to the
// parameters alone.
TEST(FactoredCovariance, AddsNoiseThatDependentQuantitiesDoNotShare) {
  FactoredCovariance factored;
  FactoredCovariance(someVariances())
      .measure(kFirstRow, kSecondRow, 0.01, 0.02, 0.0, 0.0, factored);
  FactoredCovariance::Regression regression;
  for (std::size_t k = 0; k < 5; ++k) regression[k] = TwoLanes{kFirstRow[k], -2.0 * kSecondRow[k]};
  Eigen::Matrix2d conditional;
  conditional << 0.05, 0.02, 0.02, 0.04;
  using Full = Eigen::Matrix<double, 7, 7>;
  const auto fullOf = [&] {
    Eigen::Matrix<double, 2, 5> slope;
    for (int k = 0; k < 5; ++k) slope.col(k) << regression[k][0], regression[k][1];
    Full full;
    full << conditional + slope * factored.matrix() * slope.transpose(), slope * factored.matrix(),
        (slope * factored.matrix()).transpose(), factored.matrix();
    return full;
  };
  Full expected = fullOf();
  const TwoLanes variance = factored.variance(regression);
  EXPECT_NEAR(variance[0] + conditional(0, 0), expected(0, 0), 1e-12 * expected(0, 0));
  EXPECT_NEAR(variance[1] + conditional(1, 1), expected(1, 1), 1e-12 * expected(1, 1));

  Vector direction;
  direction << 1e-2, 0.0, 3e-5, -2e-5, 1e3;
  for (const double weight : {0.5, 20.0}) {
    const auto gained = factored.add(weight, direction, regression);
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        conditional(i, j) += gained.weight * gained.factor[i] * gained.factor[j];
      }
    }
    expected.bottomRightCorner<5, 5>() += weight * direction * direction.transpose();
    EXPECT_LT(difference<Full>(fullOf(), expected), 1e-12) << weight;
  }
}

TEST(FactoredCovariance, AddsNoiseToWhatIsKnownExactly) {
  FactoredCovariance factored(Vector::Zero());
  FactoredCovariance::Regression regression = {};
  factored.add(4.0, Vector::Unit(2), regression);
  EXPECT_EQ(factored.matrix(), Matrix(4.0 * Vector::Unit(2) * Vector::Unit(2).transpose()));
}

// A full matrix has lost the sign of the smallest variance long before.
TEST(FactoredCovariance, StaysPositiveHoweverPreciseTheMeasurement) {
  FactoredCovariance factored(someVariances());
  for (int n = 0; n < 100; ++n) {
    Numbers row = kFirstRow;
    row[static_cast<std::size_t>(n % 5)] *= 3.0;
    FactoredCovariance next;
    factored.measure(row, kSecondRow, 1e-24, 1e-24, 0.0, 0.0, next);
    factored = next;
    ASSERT_TRUE(std::isfinite(factored.sum()));
    for (int k = 0; k < 5; ++k) ASSERT_GT(factored.variance()[k], 0.0) << n << " " << k;
  }
}

}  // namespace
}  // namespace ring_gyro
