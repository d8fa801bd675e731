#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "ring_gyro/common/unrolled.h"

namespace ring_gyro {

/// Unit upper triangular U and diagonal D of a covariance U D U'.
template <int N>
struct TriangularFactors {
  Eigen::Matrix<double, N, N> upper;
  Eigen::Matrix<double, N, 1> diagonal;
};

/// Factors of a sum of positive terms. What rounding makes negative is zero in truth.
template <int N>
TriangularFactors<N> factorised(Eigen::Matrix<double, N, N> covariance) {
  TriangularFactors<N> factors;
  factors.upper.setIdentity();
  for (int j = N - 1; j >= 0; --j) {
    const double variance = std::max(covariance(j, j), 0.0);
    factors.diagonal[j] = variance;
    for (int i = 0; i < j; ++i) {
      factors.upper(i, j) = variance > 0.0 ? covariance(i, j) / variance : 0.0;
    }
    for (int k = 0; k < j; ++k) {
      for (int i = 0; i <= k; ++i) {
        covariance(i, k) -= factors.upper(i, j) * factors.upper(k, j) * variance;
      }
    }
  }
  return factors;
}

/// Covariance P = U D U' of some moving states, which come first, and of kConstants states after
/// them that do not move; U unit upper triangular, D diagonal.
///
/// A square-root form: no update can make a variance negative, and the states need no scaling.
/// Moving states change only their own rows of U, everything else of a transition is identity.
template <int Moving>
class FactoredCovariance {
 public:
  static constexpr int kConstants = 5;
  static constexpr int kStates = Moving + kConstants;
  /// Of all states; what is left over is zero.
  using Vector = Eigen::Matrix<double, kStates + kStates % 2, 1>;
  template <int To>
  using Map = Eigen::Matrix<double, To, kStates>;  ///< of all states to `To` moving ones

  FactoredCovariance() = default;

  /// States that are correlated with nothing.
  explicit FactoredCovariance(const Eigen::Matrix<double, kStates, 1>& variance) {
    upper_.setZero();
    for (int j = 0; j < kStates; ++j) upper_[place(j, j)] = 1.0;
    diagonal_.template head<kStates>() = variance;
  }

  /// The moving states become correlated with nothing.
  void restartMoving(double variance) {
    for (int j = 0; j < kStates; ++j) {
      for (int i = 0; i < std::min(j, Moving); ++i) upper_[place(i, j)] = 0.0;
    }
    diagonal_.template head<Moving>().setConstant(variance);
  }

  using Constants = Eigen::Matrix<double, kConstants, 1>;

  /// Adds variances that are correlated with nothing to the constants.
  void addToConstants(const Constants& variance) {
    for (int k = 0; k < kConstants; ++k) {
      addToConstants(variance[k], Constants::Unit(k));
    }
  }

  /// Adds weight * direction direction' to the constants (Agee and Turner).
  void addToConstants(double weight, const Constants& direction) {
    Eigen::Matrix<double, kStates, 1> shape = Eigen::Matrix<double, kStates, 1>::Zero();
    shape.template tail<kConstants>() = direction;
    for (int j = kStates - 1; j >= 0 && weight > 0.0; --j) {
      const double before = diagonal_[j];
      diagonal_[j] += weight * shape[j] * shape[j];
      if (!(diagonal_[j] > 0.0)) continue;
      const double share = weight * shape[j] / diagonal_[j];
      for (int i = 0; i < j; ++i) {
        shape[i] -= shape[j] * upper_[place(i, j)];
        upper_[place(i, j)] += share * shape[i];
      }
      weight *= before / diagonal_[j];
    }
  }

  /// Makes `next` the covariance of `To` new moving states map * state + noise, and of the
  /// constants. The new moving part is orthogonalised by modified weighted Gram-Schmidt.
  template <int To>
  void propagate(const Map<To>& map, const Eigen::Matrix<double, To, To>& noise,
                 FactoredCovariance<To>& next) const {
    static_assert(Moving % 2 == 0 && To % 2 == 0, "columns are copied in pairs");
    if constexpr (Moving == 2 && To == 2) {
      propagateTwo(map, noise, next);
    } else {
      propagateMoving<To>(map, factorised<To>(noise), next);
    }
    unrolled<0, kConstants>([&](auto c) {
      constexpr int column = Moving + c;
      Eigen::Matrix<double, To, 1> moving = map.col(column);
      unrolled<0, column>([&](auto k) { moving += map.col(k) * upper_[place(k, column)]; });
      unrolled<0, To / 2>(
          [&](auto i) { next.pair(2 * i, To + c) = moving.template segment<2>(2 * i); });
      unrolled<0, (c + 2) / 2>(
          [&](auto k) { next.pair(To + 2 * k, To + c) = pair(Moving + 2 * k, column); });
      next.diagonal_[To + c] = diagonal_[column];
    });
  }

  /// Outcome of measuring one state.
  struct Measurement {
    double variance;  ///< of the measurement, noise and all
    double inverse_variance;
    Vector cross;  ///< covariance of the measurement with all states
  };

  /// Measures one moving state with this noise variance, after Bierman; the gain is the covariance
  /// with the states over the variance.
  template <int State>
  Measurement measure(double noise_variance) {
    Measurement result;
    double spread[kStates];
    double correction[kStates];
    double added[kStates] = {};
    unrolled<State, kStates>([&](auto j) {
      const double shape = upper_[place(State, j)];
      spread[j] = diagonal_[j] * shape;
      added[j] = shape * spread[j];
    });
    double variance[kStates + 1];
    variance[State] = noise_variance;
    unrolled<State, kStates>([&](auto j) {
      // Pairs first: a sum is ready after half as many steps.
      if constexpr ((j - State) % 2 == 0) {
        variance[j + 1] = variance[j] + added[j];
      } else {
        variance[j + 1] = variance[j - 1] + (added[j - 1] + added[j]);
      }
    });
    double inverse = 1.0 / noise_variance;
    unrolled<State, kStates>([&](auto j) {
      correction[j] = -upper_[place(State, j)] * inverse;
      inverse = 1.0 / variance[j + 1];
      diagonal_[j] *= variance[j] * inverse;
    });
    result.variance = variance[kStates];
    result.inverse_variance = inverse;
    // Two rows of U at a time; they do not depend on each other.
    unrolled<0, (kStates + 1) / 2>([&](auto rows) {
      constexpr int i = 2 * rows;
      Eigen::Vector2d sum = Eigen::Vector2d::Zero();
      unrolled<std::max(i, State), kStates>([&](auto j) {
        const Eigen::Vector2d old = pair(i, j);
        pair(i, j) = old + correction[j] * sum;
        sum += spread[j] * old;
      });
      result.cross.template segment<2>(i) = sum;
    });
    return result;
  }

  /// The states after the first `Dropped` moving ones.
  template <int Dropped>
  FactoredCovariance<Moving - Dropped> without() const {
    static_assert(Dropped % 2 == 0, "columns are copied in pairs");
    FactoredCovariance<Moving - Dropped> rest;
    unrolled<0, kStates - Dropped>([&](auto j) {
      unrolled<0, (j + 2) / 2>(
          [&](auto i) { rest.pair(2 * i, j) = pair(2 * i + Dropped, j + Dropped); });
      rest.diagonal_[j] = diagonal_[j + Dropped];
    });
    return rest;
  }

  double variance(int state) const {
    double sum = 0.0;
    for (int j = state; j < kStates; ++j) {
      sum += upper_[place(state, j)] * upper_[place(state, j)] * diagonal_[j];
    }
    return sum;
  }

  Eigen::Matrix<double, kStates, kStates> matrix() const {
    Eigen::Matrix<double, kStates, kStates> result;
    unrolled<0, kStates>([&](auto k) {
      double weighted[kStates];
      unrolled<k, kStates>([&](auto j) { weighted[j] = upper_[place(k, j)] * diagonal_[j]; });
      unrolled<0, k + 1>([&](auto i) {
        double sum = upper_[place(i, k)] * weighted[k];
        unrolled<k + 1, kStates>([&](auto j) { sum += upper_[place(i, j)] * weighted[j]; });
        result.coeffRef(i, k) = result.coeffRef(k, i) = sum;
      });
    });
    return result;
  }

  bool isFinite() const {
    return std::isfinite(upper_.sum() + diagonal_.template head<kStates>().sum());
  }

 private:
  template <int Other>
  friend class FactoredCovariance;

  /// Of element (i, j) in the columns of U one after the other, each to its one and from there to
  /// an even number.
  static constexpr int place(int i, int j) { return 2 * ((j + 1) / 2) * ((j + 2) / 2) + i; }
  static constexpr int kPlaces = place(0, kStates);

  // Elements are read and written two at a time: loading as two what was stored as one and one
  // makes a processor wait.
  using Pair = Eigen::Map<Eigen::Vector2d, Eigen::Aligned16>;
  using ConstPair = Eigen::Map<const Eigen::Vector2d, Eigen::Aligned16>;
  Pair pair(int i, int j) { return Pair(&upper_[place(i, j)]); }
  ConstPair pair(int i, int j) const { return ConstPair(&upper_[place(i, j)]); }

  /// The same for two states, by determinants: each is a sum of terms that are not negative, and
  /// there is less to wait for.
  void propagateTwo(const Map<2>& map, const Eigen::Matrix2d& noise,
                    FactoredCovariance<2>& next) const {
    const double share = upper_[place(0, 1)];
    const double a0 = map(0, 0);
    const double a1 = map(0, 1) + a0 * share;
    const double b0 = map(1, 0);
    const double b1 = map(1, 1) + b0 * share;
    const double d0 = diagonal_[0];
    const double d1 = diagonal_[1];
    const double b_variance = d0 * b0 * b0 + d1 * b1 * b1 + noise(1, 1);
    const double covariance = d0 * a0 * b0 + d1 * a1 * b1 + noise(0, 1);
    const auto mixed = [&noise](double a, double b) {
      return noise(0, 0) * b * b - 2.0 * noise(0, 1) * a * b + noise(1, 1) * a * a;
    };
    const double area = a0 * b1 - a1 * b0;
    const double noise_area = std::max(noise(0, 0) * noise(1, 1) - noise(0, 1) * noise(0, 1), 0.0);
    const double determinant =
        d0 * d1 * area * area + d0 * mixed(a0, b0) + d1 * mixed(a1, b1) + noise_area;
    const double inverse = b_variance > 0.0 ? 1.0 / b_variance : 0.0;
    // With no variance of b there is nothing that a could share with it.
    next.diagonal_[0] =
        b_variance > 0.0 ? determinant * inverse : d0 * a0 * a0 + d1 * a1 * a1 + noise(0, 0);
    next.diagonal_[1] = b_variance;
    next.pair(0, 0) = Eigen::Vector2d(1.0, 0.0);
    next.pair(0, 1) = Eigen::Vector2d(covariance * inverse, 1.0);
  }

  template <int To>
  void propagateMoving(const Map<To>& map, const TriangularFactors<To>& noise,
                       FactoredCovariance<To>& next) const {
    constexpr int kSources = Moving + To;
    double shape[To][kSources];
    double weight[kSources];
    unrolled<0, Moving>([&](auto j) { weight[j] = diagonal_[j]; });
    unrolled<0, To>([&](auto i) {
      weight[Moving + i] = noise.diagonal[i];
      unrolled<0, Moving>([&](auto j) {
        shape[i][j] = map.coeff(i, j);
        unrolled<0, j>([&](auto k) { shape[i][j] += map.coeff(i, k) * upper_[place(k, j)]; });
      });
      unrolled<0, To>([&](auto j) { shape[i][Moving + j] = noise.upper.coeff(i, j); });
    });
    double upper[To][To] = {};
    unrolled<0, To>([&](auto reversed) {
      constexpr int j = To - 1 - reversed;
      double weighted[kSources];
      double variance = 0.0;
      unrolled<0, kSources>([&](auto k) {
        weighted[k] = shape[j][k] * weight[k];
        variance += shape[j][k] * weighted[k];
      });
      const double inverse = variance > 0.0 ? 1.0 / variance : 0.0;
      next.diagonal_[j] = variance;
      upper[j][j] = 1.0;
      unrolled<0, j>([&](auto i) {
        double product = 0.0;
        unrolled<0, kSources>([&](auto k) { product += shape[i][k] * weighted[k]; });
        upper[i][j] = product * inverse;
        unrolled<0, kSources>([&](auto k) { shape[i][k] -= upper[i][j] * shape[j][k]; });
      });
    });
    unrolled<0, To>([&](auto j) {
      unrolled<0, (j + 2) / 2>([&](auto i) {
        next.pair(2 * i, j) = Eigen::Vector2d(upper[2 * i][j], upper[2 * i + 1][j]);
      });
    });
  }

  Eigen::Matrix<double, kPlaces, 1> upper_;
  Vector diagonal_;
};

}  // namespace ring_gyro
