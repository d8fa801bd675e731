#pragma once

#include <Eigen/Core>

#include "ring_gyro/common/lanes.h"
#include "ring_gyro/common/small_algebra.h"
#include "ring_gyro/common/unrolled.h"
#include "ring_gyro/signals/parameter_vector.h"

namespace cvg {

/// Covariance P = U D U' of the device parameters, with U unit upper triangular and D diagonal.
/// In this form no measurement can make a variance negative, and the states need no scaling.
class FactoredCovariance {
 public:
  static constexpr int kSize = 5;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;

  FactoredCovariance() = default;

  /// Parameters without correlations.
  explicit FactoredCovariance(const ParameterVector& variance) {
    for (int j = 0; j < kSize; ++j) diagonal_[j] = variance[j];
    for (int j = 1; j < kSize; ++j) {
      column(j) = FourLanes{};
      if (j < 4) column(j)[j] = 1.0;
    }
  }

  /// Result of two measurements.
  struct Outcome {
    Matrix2 innovation_covariance;  ///< with the noise
    double normalised_innovation_squared;
    Vector5 gained;  ///< change of the parameters
  };

  /// Measures rows * parameters with these innovations and the positive definite covariance
  /// `noise`, after Bierman (docs/filter.md, section 5): the first row, then the second minus the
  /// multiple of the first that makes their noise independent. `next` receives the covariance after
  /// both; it must be another object.
  Outcome measure(const Matrix2x5& rows, const Matrix2& noise, const Vector2& innovation,
                  FactoredCovariance& next) const {
    FactoredCovariance between;
    const double shared = noise.second[0] / noise.first[0];
    const Vector5 second_row = rows.second - shared * rows.first;
    const MeasuredRow first = measureRow(rows.first, noise.first[0], between);
    const MeasuredRow second =
        between.measureRow(second_row, noise.second[1] - shared * noise.second[0], next);
    // The first measurement and the subtraction reduce the second innovation by m times the first.
    const double m = shared + dot(second_row, first.k) / first.alpha;
    const double nu1 = innovation[0];
    const double nu2 = innovation[1] - m * nu1;
    const double cross = m * first.alpha;
    const double share1 = nu1 / first.alpha;
    const double share2 = nu2 / second.alpha;
    return {{Vector2{first.alpha, cross}, Vector2{cross, second.alpha + m * cross}},
            nu1 * share1 + nu2 * share2,
            share1 * first.k + share2 * second.k};
  }

  /// Adds weight * direction direction' to P (Agee and Turner; docs/filter.md, section 5). Two
  /// quantities depend on the parameters by `regression`, but do not share this new uncertainty:
  /// `regression` is computed again so that their covariance, and that with the parameters, stays.
  /// For this the caller must add weight f f' to their covariance given the parameters, with the
  /// weight and the factor f that are returned.
  struct Gained {
    double weight;
    Vector2 factor;
  };
  Gained add(double weight, const ParameterVector& direction, Matrix2x5& regression) {
    Eigen::Matrix<double, 2, kSize> rows;
    Numbers first, second;
    timesUpper(regression.first, first);
    timesUpper(regression.second, second);
    for (int j = 0; j < kSize; ++j) rows.col(j) << first[j], second[j];
    ParameterVector shape = direction;
    Eigen::Vector2d row_shape = Eigen::Vector2d::Zero();
    for (int j = kSize - 1; j >= 0 && weight > 0.0; --j) {
      const double before = diagonal_[j];
      diagonal_[j] += weight * shape[j] * shape[j];
      if (!(diagonal_[j] > 0.0)) continue;
      const double share = weight * shape[j] / diagonal_[j];
      for (int i = 0; i < j; ++i) {
        shape[i] -= shape[j] * column(j)[i];
        column(j)[i] += share * shape[i];
      }
      row_shape -= shape[j] * rows.col(j);
      rows.col(j) += share * row_shape;
      weight *= before / diagonal_[j];
    }
    for (int j = 0; j < kSize; ++j) {
      for (int i = 0; i < j; ++i) rows.col(j) -= column(j)[i] * rows.col(i);
    }
    regression = {Vector5(rows.row(0)), Vector5(rows.row(1))};
    return {weight, Vector2{row_shape[0], row_shape[1]}};
  }

  /// Variances of the two quantities regression * parameters.
  Vector2 variance(const Matrix2x5& regression) const {
    const auto of = [this](const Vector5& row) {
      Numbers through;
      timesUpper(row, through);
      double even = 0.0;
      double odd = 0.0;
      unrolled<0, kSize>(
          [&](auto j) { (j % 2 == 0 ? even : odd) += through[j] * (diagonal_[j] * through[j]); });
      return even + odd;
    };
    return Vector2{of(regression.first), of(regression.second)};
  }

  /// Variances of the parameters: the diagonal of P.
  Vector5 variance() const {
    Vector5 result(FourLanes{diagonal_[0], 0.0, 0.0, 0.0}, diagonal_[4]);
    unrolled<1, kSize>([&](auto j) { result.mismatch += column(j) * (diagonal_[j] * column(j)); });
    return result;
  }

  /// The full covariance P.
  Matrix matrix() const {
    Matrix upper = Matrix::Identity();
    for (int j = 1; j < kSize; ++j) {
      for (int i = 0; i < j; ++i) upper(i, j) = column(j)[i];
    }
    const Matrix weighted = upper * diagonal().asDiagonal();
    Matrix result;
    for (int i = 0; i < kSize; ++i) {
      for (int j = i; j < kSize; ++j) {
        result(i, j) = result(j, i) = weighted.row(i).dot(upper.row(j));
      }
    }
    return result;
  }

  /// Sum of all numbers in it: finite only if all of them are finite.
  double sum() const {
    double sum = sumOf((column(1) + column(2)) + (column(3) + column(4)));
    unrolled<0, kSize>([&](auto j) { sum += diagonal_[j]; });
    return sum;
  }

 private:
  using Numbers = double[kSize];

  /// Result of measuring one row; P is the covariance before.
  struct MeasuredRow {
    double alpha;  ///< variance of the innovation: row' P row + noise
    Vector5 k;     ///< P row
  };

  /// Measures row * parameters with noise of this variance: Bierman's recursion over the columns.
  MeasuredRow measureRow(const Vector5& row, double noise, FactoredCovariance& next) const {
    Numbers v, dv;  // U' row and D U' row
    timesUpper(row, v);
    unrolled<0, kSize>([&](auto j) { dv[j] = diagonal_[j] * v[j]; });
    double alpha[kSize + 1];
    runningSums(noise, dv, v, alpha);
    next.diagonal_[0] = diagonal_[0] * (alpha[0] / alpha[1]);
    FourLanes k = {dv[0], 0.0, 0.0, 0.0};
    unrolled<1, kSize>([&](auto j) {
      next.diagonal_[j] = diagonal_[j] * (alpha[j] / alpha[j + 1]);
      next.column(j) = column(j) - (v[j] / alpha[j]) * k;
      k += dv[j] * column(j);
    });
    return {alpha[kSize], Vector5(k, dv[4])};
  }

  /// The first four rows of column j of U, with its ones and zeros, for j = 1 to 4. Column 0 is
  /// known and not stored.
  FourLanes& column(int j) { return columns_[j - 1]; }
  const FourLanes& column(int j) const { return columns_[j - 1]; }

  Eigen::Map<const ParameterVector> diagonal() const {
    return Eigen::Map<const ParameterVector>(diagonal_);
  }

  /// U' row.
  void timesUpper(const Vector5& row, Numbers& result) const {
    const FourLanes& mismatch = row.mismatch;
    const Numbers numbers = {mismatch[0], mismatch[1], mismatch[2], mismatch[3], row.drive_gain};
    // `i` is a constant of its own type, which cannot index a vector; i.value can.
    unrolled<0, kSize>([&](auto j) {
      double even = numbers[j];
      double odd = 0.0;
      unrolled<0, j>([&](auto i) { (i % 2 == 0 ? even : odd) += column(j)[i.value] * numbers[i]; });
      result[j] = even + odd;
    });
  }

  /// sums[j]: `start` plus the first j products. They are added in pairs, so that the last sum
  /// waits for half as many additions.
  static void runningSums(double start, const Numbers& one, const Numbers& other,
                          double (&sums)[kSize + 1]) {
    sums[0] = start;
    unrolled<0, kSize>([&](auto j) {
      if constexpr (j % 2 == 0) {
        sums[j + 1] = sums[j] + one[j] * other[j];
      } else {
        sums[j + 1] = sums[j - 1] + (one[j - 1] * other[j - 1] + one[j] * other[j]);
      }
    });
  }

  FourLanes columns_[kSize - 1];
  Numbers diagonal_;
};

}  // namespace cvg
