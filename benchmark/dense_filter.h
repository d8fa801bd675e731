#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <complex>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/identification/filter/interval_filter.h"
#include "ring_gyro/identification/model/averaged_model.h"

namespace cvg {

/// The filter (29) as most C++ Kalman libraries write it: seven states, full 7x7 matrices of fixed
/// size, predict, update, Joseph's form. It knows nothing of what is zero or identity.
///
/// The model is written out here once more, by itself, in the number type of the filter: in long
/// double this is the reference for the accuracy, in double the peer for the speed. Midpoint step,
/// as in AveragedModel.
template <typename Real>
class DenseFilter {
 public:
  using State = Eigen::Matrix<Real, 7, 1>;
  using Square = Eigen::Matrix<Real, 7, 7>;
  using Pair = Eigen::Matrix<Real, 2, 1>;

  /// Natural frequency [Hz] and Q of the ring; standard deviations `sigma` of the state.
  DenseFilter(double natural_frequency, double quality_factor, const IntervalNoise& noise,
              const StateVector& value, const StateVector& sigma)
      : w0_(Real(kTwoPi) * Real(natural_frequency)),
        decay_(w0_ / (2 * Real(quality_factor))),
        noise_(noise),
        value_(value.cast<Real>()),
        covariance_(Square(sigma.cast<Real>().cwiseAbs2().asDiagonal())) {
    observation_.setZero();
    observation_(0, 0) = observation_(1, 1) = 1;
    measurement_noise_ = Real(noise.sample_variance) * Eigen::Matrix<Real, 2, 2>::Identity();
  }

  void predict(double theta, double phi, const AveragedInput& input, double duration) {
    const Real h = duration;
    const Real scale = Real(0.5) / Real(input.reference_frequency);
    const Real coupling = scale * w0_ * w0_;
    const Real turning = scale * Real(input.pattern_rate);
    const Real cosine = std::cos(Real(theta)), sine = std::sin(Real(theta));
    const Real cos2 = cosine * cosine - sine * sine, sin2 = 2 * cosine * sine;
    const Real re = std::cos(Real(phi)), im = -std::sin(Real(phi));
    const std::complex<double> fx = input.drive.x(), fy = input.drive.y();
    const Real xr = fx.real(), xi = fx.imag(), yr = fy.real(), yi = fy.imag();
    const Real along_re = cosine * xr + sine * yr, along_im = cosine * xi + sine * yi;
    const Real across_re = cosine * yr - sine * xr, across_im = cosine * yi - sine * xi;
    const Pair force(scale * (re * along_im + im * along_re),
                     scale * (re * across_re - im * across_im));
    const Real force_turn = scale * (re * across_im + im * across_re);
    const Real force_lag = -scale * (re * along_re - im * along_im);

    const Real g1 = value_[2], g2 = value_[3], m1 = value_[4], m2 = value_[5], ks = value_[6];
    const Real gamma = g1 * cos2 + g2 * sin2, mu = coupling * (m2 * cos2 - m1 * sin2);
    const Real a_decay = decay_ * (1 + gamma), b_decay = decay_ * (1 - gamma);
    Eigen::Matrix<Real, 2, 2> matrix;
    matrix << -a_decay - turning * mu, mu - turning * a_decay, -mu - turning * b_decay,
        -b_decay + turning * mu;
    const Pair axes = value_.template head<2>();
    const Pair middle = axes + h / 2 * (matrix * axes + ks * force);
    const auto byParameters = [&](const Pair& at) {
      const Real da = decay_ * (at[0] + turning * at[1]), db = decay_ * (at[1] + turning * at[0]);
      const Real sa = coupling * (at[0] - turning * at[1]);
      const Real sb = coupling * (at[1] - turning * at[0]);
      Eigen::Matrix<Real, 2, 5> result;
      result << -cos2 * da, -sin2 * da, -sin2 * sb, cos2 * sb, force[0],  //
          cos2 * db, sin2 * db, sin2 * sa, -cos2 * sa, force[1];
      return result;
    };
    // Slopes with respect to the angles, whose noise acts on a' and b'.
    const Real gamma_slope = 2 * decay_ * (g2 * cos2 - g1 * sin2);
    const Real mu_slope = -2 * coupling * (m1 * cos2 + m2 * sin2);
    Eigen::Matrix<Real, 2, 2> by_angles;
    by_angles << ks * force_turn - gamma_slope * (axes[0] + turning * axes[1]) +
                     mu_slope * (axes[1] - turning * axes[0]),
        ks * force_lag,
        ks * force_lag + gamma_slope * (axes[1] + turning * axes[0]) -
            mu_slope * (axes[0] - turning * axes[1]),
        ks * force_turn;

    Square transition = Square::Identity();
    transition.template topLeftCorner<2, 2>() +=
        h * matrix * (Eigen::Matrix<Real, 2, 2>::Identity() + h / 2 * matrix);
    transition.template topRightCorner<2, 5>() =
        h * (byParameters(middle) + h / 2 * matrix * byParameters(axes));
    Square process = Square::Zero();
    process.template topLeftCorner<2, 2>() =
        h * (Real(noise_.angle_density) / axes.squaredNorm() * by_angles * by_angles.transpose() +
             Real(noise_.axes_density) * Eigen::Matrix<Real, 2, 2>::Identity());

    value_.template head<2>() += h * (matrix * middle + ks * force);
    covariance_ = (transition * covariance_ * transition.transpose() + process).eval();
  }

  void update(const Eigen::Vector2d& measured) {
    const Eigen::Matrix<Real, 2, 2> innovation_covariance =
        observation_ * covariance_ * observation_.transpose() + measurement_noise_;
    const Eigen::Matrix<Real, 7, 2> gain =
        covariance_ * observation_.transpose() * innovation_covariance.inverse();
    value_ += gain * (measured.cast<Real>() - observation_ * value_);
    const Square rest = Square::Identity() - gain * observation_;
    covariance_ =
        (rest * covariance_ * rest.transpose() + gain * measurement_noise_ * gain.transpose())
            .eval();
  }

  const State& value() const { return value_; }
  Real sigma(int state) const { return std::sqrt(covariance_(state, state)); }

 private:
  Real w0_;
  Real decay_;
  IntervalNoise noise_;
  State value_;
  Square covariance_;
  Eigen::Matrix<Real, 2, 7> observation_;
  Eigen::Matrix<Real, 2, 2> measurement_noise_;
};

}  // namespace cvg
