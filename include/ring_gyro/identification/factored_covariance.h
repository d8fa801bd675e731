#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

#include "ring_gyro/common/lanes.h"
#include "ring_gyro/common/unrolled.h"

namespace ring_gyro {

/// Covariance U D U' of the device parameters, U unit upper triangular, D diagonal: a square-root
/// form, which no measurement can make negative, and which needs no scaling of the states.
class FactoredCovariance {
 public:
  static constexpr int kSize = 5;
  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  /// Of two other quantities on the parameters, by columns.
  using Regression = std::array<TwoLanes, kSize>;

  FactoredCovariance() = default;

  /// Parameters that are correlated with nothing.
  explicit FactoredCovariance(const Vector& variance) : diagonal_(variance) {
    for (double& element : upper_) element = 0.0;
  }

  using Numbers = std::array<double, kSize>;

  /// What two measurements with independent noise brought about.
  struct Outcome {
    double first_variance;     ///< of the first, noise and all, before
    double second_variance;    ///< of the second, after the first
    double common;             ///< covariance of the two, before
    double first_share;        ///< first innovation over its variance
    double second_innovation;  ///< that of the second which the first does not explain
    Numbers gained;            ///< by the parameters
  };

  /// Measures first_row * parameters, then second_row * parameters, with these innovations and
  /// noise variances above zero, after Bierman. Both go through the factors as they were, and what
  /// the first does to the second is added (in the coordinates of U it is one number a column):
  /// so the second does not wait until the first has been through the factors. `next`: the
  /// covariance after both, another object.
  Outcome measure(const Numbers& first_row, const Numbers& second_row, double first_noise,
                  double second_noise, double first_innovation, double second_innovation,
                  FactoredCovariance& next) const {
    double first[kSize], second[kSize];                // U' row
    double first_spread[kSize], second_spread[kSize];  // D U' row
    double first_step[kSize], second_step[kSize];      // what each column takes of those before it
    double diagonal[kSize];
    double common[kSize + 1];
    double variance[kSize + 1];
    unrolled<0, kSize>([&](auto j) {
      first[j] = timesColumn<j>(first_row);
      second[j] = timesColumn<j>(second_row);
      first_spread[j] = diagonal_[j] * first[j];
    });
    runningSums(first_noise, first_spread, first, variance);
    runningSums(0.0, first_spread, second, common);
    double inverse = 1.0 / first_noise;
    unrolled<0, kSize>([&](auto j) {
      first_step[j] = -first[j] * inverse;
      inverse = 1.0 / variance[j + 1];
      diagonal[j] = diagonal_[j] * (variance[j] * inverse);
      second[j] += first_step[j] * common[j];
      second_spread[j] = diagonal[j] * second[j];
    });
    Outcome outcome;
    outcome.first_variance = variance[kSize];
    outcome.common = common[kSize];
    outcome.first_share = first_innovation * inverse;
    outcome.second_innovation = second_innovation - outcome.common * outcome.first_share;

    runningSums(second_noise, second_spread, second, variance);
    outcome.second_variance = variance[kSize];
    inverse = 1.0 / second_noise;
    unrolled<0, kSize>([&](auto j) {
      second_step[j] = -second[j] * inverse;
      inverse = 1.0 / variance[j + 1];
      next.diagonal_[j] = diagonal[j] * (variance[j] * inverse);
    });

    const double second_share = outcome.second_innovation * inverse;
    double gained[kSize];
    double after = 0.0;
    unrolled<0, kSize>([&](auto reversed) {
      constexpr int j = kSize - 1 - reversed;
      gained[j] = outcome.first_share * first_spread[j] +
                  second_share * (second_spread[j] + after * first_spread[j]);
      after += first_step[j] * second_spread[j];
    });
    unrolled<0, kSize>([&](auto i) {
      outcome.gained[i] = gained[i];
      unrolled<i + 1, kSize>([&](auto j) { outcome.gained[i] += upper_[place(i, j)] * gained[j]; });
    });
    double between[kPlaces];
    takeSteps(first_step, first_spread, upper_, between);
    takeSteps(second_step, second_spread, between, next.upper_);
    return outcome;
  }

  /// Adds weight * direction direction' (Agee and Turner). Two quantities that depend on the
  /// parameters by `regression` do not move with them: it is made anew. Gives their common factor f
  /// and the weight of the covariance weight f f' that they gain beside it.
  struct Gained {
    double weight;
    TwoLanes factor;
  };
  Gained add(double weight, const Vector& direction, Regression& regression) {
    Regression rows = timesUpper(regression);
    Vector shape = direction;
    TwoLanes row_shape = {};
    for (int j = kSize - 1; j >= 0 && weight > 0.0; --j) {
      const double before = diagonal_[j];
      diagonal_[j] += weight * shape[j] * shape[j];
      if (!(diagonal_[j] > 0.0)) continue;
      const double share = weight * shape[j] / diagonal_[j];
      for (int i = 0; i < j; ++i) {
        shape[i] -= shape[j] * upper_[place(i, j)];
        upper_[place(i, j)] += share * shape[i];
      }
      row_shape -= shape[j] * rows[j];
      rows[j] += share * row_shape;
      weight *= before / diagonal_[j];
    }
    for (int j = 0; j < kSize; ++j) {
      for (int i = 0; i < j; ++i) rows[j] -= upper_[place(i, j)] * rows[i];
    }
    regression = rows;
    return {weight, row_shape};
  }

  /// Variances of the two quantities regression * parameters.
  TwoLanes variance(const Regression& regression) const {
    const Regression rows = timesUpper(regression);
    TwoLanes sum = {};
    unrolled<0, kSize>([&](auto j) { sum += rows[j] * (diagonal_[j] * rows[j]); });
    return sum;
  }

  Vector variance() const {
    Vector result = diagonal_;
    unrolled<0, kSize>([&](auto j) {
      unrolled<0, j>(
          [&](auto i) { result[i] += upper_[place(i, j)] * (upper_[place(i, j)] * diagonal_[j]); });
    });
    return result;
  }

  Matrix matrix() const {
    Matrix upper = Matrix::Identity();
    for (int j = 0; j < kSize; ++j) {
      for (int i = 0; i < j; ++i) upper(i, j) = upper_[place(i, j)];
    }
    const Matrix weighted = upper * diagonal_.asDiagonal();
    Matrix result;
    for (int i = 0; i < kSize; ++i) {
      for (int j = i; j < kSize; ++j) {
        result(i, j) = result(j, i) = weighted.row(i).dot(upper.row(j));
      }
    }
    return result;
  }

  /// Of the numbers in it: not finite unless all of them are.
  double sum() const {
    double sum = 0.0;
    unrolled<0, kSize>([&](auto j) {
      sum += diagonal_[j];
      unrolled<0, j>([&](auto i) { sum += upper_[place(i, j)]; });
    });
    return sum;
  }

 private:
  /// Of element (i, j), i < j, in the columns of U one after the other.
  static constexpr int place(int i, int j) { return j * (j - 1) / 2 + i; }
  static constexpr int kPlaces = kSize * (kSize - 1) / 2;

  /// Element j of U' row.
  template <int j>
  double timesColumn(const Numbers& row) const {
    double even = row[j];
    double odd = 0.0;
    unrolled<0, j>([&](auto i) { (i % 2 == 0 ? even : odd) += upper_[place(i, j)] * row[i]; });
    return even + odd;
  }

  /// sums[j]: `start` and the first j products; by pairs, so that a sum is ready after half as many
  /// steps.
  static void runningSums(double start, const double (&one)[kSize], const double (&other)[kSize],
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

  /// U after a measurement.
  static void takeSteps(const double (&step)[kSize], const double (&spread)[kSize],
                        const double (&upper)[kPlaces], double (&next)[kPlaces]) {
    double gathered[kSize];
    unrolled<0, kSize>([&](auto j) {
      unrolled<0, j>([&](auto i) {
        next[place(i, j)] = upper[place(i, j)] + step[j] * gathered[i];
        gathered[i] += spread[j] * upper[place(i, j)];
      });
      gathered[j] = spread[j];
    });
  }

  Regression timesUpper(const Regression& regression) const {
    Regression rows = regression;
    unrolled<0, kSize>([&](auto j) {
      unrolled<0, j>([&](auto i) { rows[j] += upper_[place(i, j)] * regression[i]; });
    });
    return rows;
  }

  double upper_[kPlaces];
  Vector diagonal_;
};

}  // namespace ring_gyro
