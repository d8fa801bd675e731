#include "ring_gyro/common/small_algebra.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <complex>

namespace cvg {
namespace {

const Matrix2 kOne = {Vector2{1.0, 2.0}, Vector2{-3.0, 5.0}};
const Matrix2 kOther = {Vector2{0.5, -1.0}, Vector2{4.0, 0.25}};
const Vector2 kVector = {3.0, -7.0};

// The numbers are chosen so that all results are exact, whatever the order of sums.
TEST(SmallAlgebra, MatricesAreThoseOfEigen) {
  const Eigen::Matrix2d one = eigen(kOne), other = eigen(kOther);
  EXPECT_EQ(one(0, 0), 1.0);
  EXPECT_EQ(one(1, 0), 2.0);
  EXPECT_EQ(one(0, 1), -3.0);
  EXPECT_EQ(one(1, 1), 5.0);
  EXPECT_EQ(eigen(kOne + kOther), one + other);
  EXPECT_EQ(eigen(kOne - kOther), one - other);
  EXPECT_EQ(eigen(2.0 * kOne), 2.0 * one);
  EXPECT_EQ(eigen(kOne + 2.0), one + 2.0 * Eigen::Matrix2d::Identity());
  EXPECT_EQ(eigen(kOne - 2.0), one - 2.0 * Eigen::Matrix2d::Identity());
  EXPECT_EQ(eigen(kOne * kOther), one * other);
  EXPECT_EQ(eigen(kOne * kVector), one * eigen(kVector));
  EXPECT_EQ(eigen(transposed(kOne)), one.transpose());
  EXPECT_EQ(determinant(kOne), one.determinant());
  EXPECT_TRUE(eigen(inverse(kOne)).isApprox(one.inverse(), 1e-15));
  EXPECT_EQ(eigen(symmetric(kOne)), 0.5 * (one + one.transpose()));
  EXPECT_EQ(eigen(outer(kVector, Vector2{2.0, 0.5})),
            eigen(kVector) * Eigen::RowVector2d(2.0, 0.5));
  EXPECT_EQ(eigen(Matrix2::diagonal(2.0, 3.0)),
            Eigen::Matrix2d(Eigen::Vector2d(2, 3).asDiagonal()));
}

TEST(SmallAlgebra, VectorsOfTwo) {
  EXPECT_EQ(eigen(vector2(Eigen::Vector2d(3.0, -7.0))), Eigen::Vector2d(3.0, -7.0));
  EXPECT_EQ(eigen(magnitude(kVector)), Eigen::Vector2d(3.0, 7.0));
  EXPECT_EQ(eigen(swapped(kVector)), Eigen::Vector2d(-7.0, 3.0));
}

TEST(SmallAlgebra, RowsOverTheParametersAreThoseOfEigen) {
  using Eigen5 = Eigen::Matrix<double, 5, 1>;
  const Eigen5 first = (Eigen5() << 1.0, -2.0, 3.0, 0.5, 8.0).finished();
  const Eigen5 second = (Eigen5() << 4.0, 1.0, -0.25, 2.0, -1.0).finished();
  const Matrix2x5 rows = {Vector5(first), Vector5(second)};
  Eigen::Matrix<double, 2, 5> full;
  full << first.transpose(), second.transpose();
  EXPECT_EQ(eigen(Vector5(first)), first);
  EXPECT_EQ(eigen(rows), full);
  EXPECT_EQ(eigen(Vector5(first) + Vector5(second)), first + second);
  EXPECT_EQ(eigen(Vector5(first) - Vector5(second)), first - second);
  EXPECT_EQ(eigen(2.0 * Vector5(first)), 2.0 * first);
  EXPECT_EQ(sumOf(Vector5(first)), first.sum());
  EXPECT_EQ(dot(Vector5(first), Vector5(second)), first.dot(second));
  EXPECT_EQ(eigen(rows + rows), full + full);
  EXPECT_EQ(eigen(rows - 3.0 * rows), full - 3.0 * full);
  EXPECT_EQ(eigen(kOne * rows), eigen(kOne) * full);
  EXPECT_EQ(eigen(rows * Vector5(second)), full * second);
}

template <typename Real>
Phasor<double> lane(const Phasor<Real>& phasor, std::size_t k) {
  return {phasor.re[k], phasor.im[k]};
}

void expectEqual(const Phasor<double>& found, const std::complex<double>& expected) {
  EXPECT_EQ(found.re, expected.real());
  EXPECT_EQ(found.im, expected.imag());
}

TEST(SmallAlgebra, PhasorsAreComplexNumbers) {
  const std::complex<double> one(3.0, -0.5), other(-2.0, 4.0), i(0.0, 1.0);
  const Phasor<double> p = phasor(one), q = phasor(other);
  expectEqual(p + q, one + other);
  expectEqual(p - q, one - other);
  expectEqual(p * q, one * other);
  expectEqual(2.5 * p, 2.5 * one);
  expectEqual(conjugate(p), std::conj(one));
  expectEqual(timesI(p), i * one);

  Phasor<Lanes> many, others;
  for (std::size_t k = 0; k < kLanes; ++k) {
    many.re[k] = static_cast<double>(k);
    many.im[k] = 1.0 - static_cast<double>(k);
    others.re[k] = 0.5;
    others.im[k] = static_cast<double>(2 * k);
  }
  const Phasor<Lanes> product = many * conjugate(timesI(others));
  for (std::size_t k = 0; k < kLanes; ++k) {
    const std::complex<double> a(many.re[k], many.im[k]), b(others.re[k], others.im[k]);
    expectEqual(lane(product, k), a * std::conj(i * b));
  }
}

}  // namespace
}  // namespace cvg
