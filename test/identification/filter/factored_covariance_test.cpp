#include "ring_gyro/identification/filter/factored_covariance.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

namespace cvg {
namespace {

using Vector = ParameterVector;
using Matrix = FactoredCovariance::Matrix;

Vector someVariances() {
  Vector variance;
  variance << 1e-3, 2e-3, 1e-9, 3e-9, 1e8;
  return variance;
}

const Vector kFirstRow = (Vector() << 3.0, -4.0, 2e3, 1e3, 2e-5).finished();
const Vector kSecondRow = (Vector() << 1.0, 5.0, -4e3, 2e3, -1e-5).finished();

Matrix2x5 rowsOf(const Vector& first, const Vector& second) {
  return {Vector5(first), Vector5(second)};
}

/// Difference relative to the standard deviations.
template <typename Full>
double difference(const Full& covariance, const Full& expected) {
  const auto scale = expected.diagonal().cwiseSqrt().cwiseInverse().eval();
  return (scale.asDiagonal() * (covariance - expected) * scale.asDiagonal()).cwiseAbs().maxCoeff();
}

const Matrix2 kNoise = {Vector2{0.01, 0.004}, Vector2{0.004, 0.02}};

TEST(FactoredCovariance, MeasuresAsFullMatricesDo) {
  FactoredCovariance factored(someVariances());
  Matrix full = someVariances().asDiagonal();
  for (int n = 0; n < 5; ++n) {
    Eigen::Matrix<double, 2, 5> rows;
    rows << kFirstRow.transpose(), kSecondRow.transpose();
    rows(0, n) *= 1.7;  // different directions each time
    FactoredCovariance next;
    const FactoredCovariance::Outcome outcome =
        factored.measure(rowsOf(rows.row(0), rows.row(1)), kNoise, Vector2{0.3, -0.2}, next);

    Eigen::Matrix2d noise;
    noise << 0.01, 0.004, 0.004, 0.02;
    const Eigen::Vector2d innovation(0.3, -0.2);
    const Eigen::Matrix2d expected = rows * full * rows.transpose() + noise;
    const Eigen::Matrix<double, 5, 2> gain = full * rows.transpose() * expected.inverse();
    const Vector gained = gain * innovation;
    full -= (gain * expected * gain.transpose()).eval();

    const Matrix2& covariance = outcome.innovation_covariance;
    const double scale = 1e-12 * expected.trace();
    EXPECT_NEAR(covariance.first[0], expected(0, 0), scale);
    EXPECT_NEAR(covariance.first[1], expected(1, 0), scale);
    EXPECT_NEAR(covariance.second[0], expected(0, 1), scale);
    EXPECT_NEAR(covariance.second[1], expected(1, 1), scale);
    const double nis = innovation.dot(expected.inverse() * innovation);
    EXPECT_NEAR(outcome.normalised_innovation_squared, nis, 1e-10 * nis);
    ASSERT_LT(difference<Matrix>(next.matrix(), full), 1e-10) << n;
    for (int k = 0; k < 5; ++k) {
      EXPECT_NEAR(eigen(outcome.gained)[k], gained[k], 1e-10 * std::sqrt(full(k, k)))
          << n << " " << k;
      EXPECT_NEAR(eigen(next.variance())[k], full(k, k), 1e-10 * full(k, k));
    }
    factored = next;
  }
}

// Against one full matrix of the two dependent quantities and the five parameters, where noise is
// added to the parameters only.
TEST(FactoredCovariance, AddsNoiseThatDependentQuantitiesDoNotShare) {
  FactoredCovariance factored;
  FactoredCovariance(someVariances())
      .measure(rowsOf(kFirstRow, kSecondRow), kNoise, Vector2{}, factored);
  Matrix2x5 regression = rowsOf(kFirstRow, -2.0 * kSecondRow);
  Eigen::Matrix2d conditional;
  conditional << 0.05, 0.02, 0.02, 0.04;
  using Full = Eigen::Matrix<double, 7, 7>;
  const auto fullOf = [&] {
    Eigen::Matrix<double, 2, 5> slope;
    slope << eigen(regression.first).transpose(), eigen(regression.second).transpose();
    Full full;
    full << conditional + slope * factored.matrix() * slope.transpose(), slope * factored.matrix(),
        (slope * factored.matrix()).transpose(), factored.matrix();
    return full;
  };
  Full expected = fullOf();
  const Vector2 variance = factored.variance(regression);
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
  Matrix2x5 regression;
  factored.add(4.0, Vector::Unit(2), regression);
  EXPECT_EQ(factored.matrix(), Matrix(4.0 * Vector::Unit(2) * Vector::Unit(2).transpose()));
}

// In a full matrix rounding would have made the smallest variance negative long before.
TEST(FactoredCovariance, StaysPositiveHoweverPreciseTheMeasurement) {
  FactoredCovariance factored(someVariances());
  for (int n = 0; n < 100; ++n) {
    Vector row = kFirstRow;
    row[n % 5] *= 3.0;
    FactoredCovariance next;
    factored.measure(rowsOf(row, kSecondRow), Matrix2::diagonal(1e-24, 1e-24), Vector2{}, next);
    factored = next;
    ASSERT_TRUE(std::isfinite(factored.sum()));
    for (int k = 0; k < 5; ++k) ASSERT_GT(eigen(factored.variance())[k], 0.0) << n << " " << k;
  }
}

}  // namespace
}  // namespace cvg
