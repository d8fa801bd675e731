#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <complex>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/device_knowledge.h"
#include "ring_gyro/identification/filter/interval_filter.h"
#include "ring_gyro/identification/model/averaged_model.h"
#include "ring_gyro/signals/parameter_estimate.h"

namespace cvg {

/// Start reading here: the filter of the paper's section 5 on the model of its section 4, written
/// with full matrices as the equations are. IntervalFilter gives the same numbers in less time; its
/// tests and its benchmark compare it with this filter (in long double too). Read next:
/// axes_equation.h (the step), interval_filter.h, factored_covariance.h, with docs/filter.md.
///
/// Differences from the paper (docs/derivation.md): the signs where the paper has misprints;
/// w0^2 / (2 w) instead of w0 / 2 as the factor of mu; the second-order terms in the pattern's rate
/// (e below, section 8); a drive at any phase (section 5) instead of beta and alpha at
/// phi = -pi/2. The noise of the measured angles is added (docs/filter.md, section 1). A midpoint
/// step replaces Euler's step of (1); its error at 1 kHz is far below a sigma.
template <typename Real>
class PaperFilter {
 public:
  /// (29): X = [a, b, gamma1, gamma2, mu1, mu2, ks].
  using State = Eigen::Matrix<Real, 7, 1>;
  using Matrix7 = Eigen::Matrix<Real, 7, 7>;
  using Vector2 = Eigen::Matrix<Real, 2, 1>;
  using Matrix2 = Eigen::Matrix<Real, 2, 2>;
  using Matrix2x5 = Eigen::Matrix<Real, 2, 5>;

  /// X_k = f(X_{k-1}, u) with its Jacobian A and the covariance Q of its process noise.
  struct Step {
    State after;
    Matrix7 jacobian;
    Matrix7 noise;
  };

  /// f0 and Q of `device` are taken as exact; `sigma`: standard deviations of `value`.
  PaperFilter(const DeviceKnowledge& device, const IntervalNoise& noise, const StateVector& value,
              const StateVector& sigma)
      : w0_(Real(kTwoPi) * Real(device.natural_frequency)),
        d_(w0_ / (2 * Real(device.quality_factor))),
        noise_(noise),
        x_(value.cast<Real>()),
        p_(Matrix7(sigma.cast<Real>().cwiseAbs2().asDiagonal())) {}

  /// (1): one step of `dt` [s] from `x`; theta, phi and the inputs are those of its middle.
  Step step(const State& x, double theta, double phi, const AveragedInput& u, double dt) const {
    const Angle at(*this, theta, phi, u);
    const Real h = dt;
    const Vector2 axes = x.template head<2>();  // a, b
    const Real ks = x[6];
    const Matrix2 m = axesMatrix(x, at);
    const Vector2 middle = axes + h / 2 * (m * axes + ks * at.force);

    // (30)(31): a and b move, the parameters stay.
    Step result;
    result.after = x;
    result.after.template head<2>() += h * (m * middle + ks * at.force);

    // (4), the entries (32) and columns (33), of the midpoint step.
    result.jacobian = Matrix7::Identity();
    result.jacobian.template topLeftCorner<2, 2>() += h * m * (Matrix2::Identity() + h / 2 * m);
    result.jacobian.template topRightCorner<2, 5>() =
        h * (byParameters(middle, at) + h / 2 * m * byParameters(axes, at));

    // Noise for what the model leaves out, and noise of the angles through the slopes of the rate.
    const Matrix2 slopes = byAngles(x, at);
    result.noise.setZero();
    result.noise.template topLeftCorner<2, 2>() =
        h * (Real(noise_.axes_density) * Matrix2::Identity() +
             Real(noise_.angle_density) / axes.squaredNorm() * slopes * slopes.transpose());
    return result;
  }

  /// (2), step 1: prediction.
  void predict(double theta, double phi, const AveragedInput& u, double dt) {
    const Step f = step(x_, theta, phi, u, dt);
    x_ = f.after;
    p_ = (f.jacobian * p_ * f.jacobian.transpose() + f.noise).eval();
  }

  /// (3), step 2: correction with a measured (a, b) [V].
  void correct(const Eigen::Vector2d& z) {
    Eigen::Matrix<Real, 2, 7> h = Eigen::Matrix<Real, 2, 7>::Zero();  // (5): a and b are measured
    h(0, 0) = h(1, 1) = 1;
    const Matrix2 r = Real(noise_.sample_variance) * Matrix2::Identity();
    const Eigen::Matrix<Real, 7, 2> k = p_ * h.transpose() * (h * p_ * h.transpose() + r).inverse();
    x_ += k * (z.cast<Real>() - h * x_);
    // (I - K H) P in Joseph's form: the same, but rounding cannot make a variance negative.
    const Matrix7 rest = Matrix7::Identity() - k * h;
    p_ = (rest * p_ * rest.transpose() + k * r * k.transpose()).eval();
  }

  const State& value() const { return x_; }
  const Matrix7& covariance() const { return p_; }
  Real sigma(int state) const { return std::sqrt(p_(state, state)); }

 private:
  /// Everything that depends only on theta, phi and the inputs.
  struct Angle {
    Angle(const PaperFilter& filter, double theta, double phi, const AveragedInput& u) {
      const Real w = u.reference_frequency;
      k2 = filter.w0_ * filter.w0_ / (2 * w);
      e = Real(u.pattern_rate) / (2 * w);
      c = std::cos(2 * Real(theta));
      s = std::sin(2 * Real(theta));
      // Of docs/derivation.md: [F1; F2] = R(-theta) F in pattern axes, E = e^{-i phi}.
      using Complex = std::complex<Real>;
      const Complex fx(u.drive.x().real(), u.drive.x().imag());
      const Complex fy(u.drive.y().real(), u.drive.y().imag());
      const Real cosine = std::cos(Real(theta)), sine = std::sin(Real(theta));
      const Complex lag(std::cos(Real(phi)), -std::sin(Real(phi)));
      const Complex f1 = lag * (cosine * fx + sine * fy) / (2 * w);
      const Complex f2 = lag * (cosine * fy - sine * fx) / (2 * w);
      force << f1.imag(), f2.real();            // fa / ks, fb / ks
      force_by_theta << f2.imag(), -f1.real();  // F1' = F2, F2' = -F1
      force_by_phi << -f1.real(), f2.imag();    // E' = -i E
    }
    Real k2;    ///< w0^2 / (2 w); w0 / 2 in the paper
    Real e;     ///< theta' / (2 w), of the second-order terms
    Real c, s;  ///< of 2 theta
    Vector2 force, force_by_theta, force_by_phi;
  };

  /// (16)(17) without the drive, a' and b' as a matrix times (a, b):
  ///   a' = -a xi0 w0 (1 + gamma1 c + gamma2 s) - b K2 (mu1 s - mu2 c)
  ///   b' = -b xi0 w0 (1 - gamma1 c - gamma2 s) + a K2 (mu1 s - mu2 c),
  /// with (a + e b) for a and (b + e a) for b in the terms with gamma, and (b - e a) for b and
  /// (a - e b) for a in the terms with mu (docs/derivation.md, section 8).
  Matrix2 axesMatrix(const State& x, const Angle& at) const {
    const Real gamma = x[2] * at.c + x[3] * at.s;
    const Real mu = at.k2 * (x[4] * at.s - x[5] * at.c);
    const Real da = d_ * (1 + gamma), db = d_ * (1 - gamma);
    Matrix2 m;
    m << -da + at.e * mu, -mu - at.e * da,  //
        mu - at.e * db, -db - at.e * mu;
    return m;
  }

  /// The columns of (33): a' and b' with respect to gamma1, gamma2, mu1, mu2, ks.
  Matrix2x5 byParameters(const Vector2& axes, const Angle& at) const {
    const Real a = axes[0], b = axes[1], e = at.e, c = at.c, s = at.s;
    const Real da = d_ * (a + e * b), db = d_ * (b + e * a);
    const Real ka = at.k2 * (a - e * b), kb = at.k2 * (b - e * a);
    Matrix2x5 columns;
    columns << -c * da, -s * da, -s * kb, c * kb, at.force[0],  //
        c * db, s * db, s * ka, -c * ka, at.force[1];
    return columns;
  }

  /// a' and b' with respect to theta and phi; the paper takes these angles as exact.
  Matrix2 byAngles(const State& x, const Angle& at) const {
    const Real a = x[0], b = x[1], e = at.e, ks = x[6];
    const Real gamma = 2 * d_ * (x[3] * at.c - x[2] * at.s);
    const Real mu = 2 * at.k2 * (x[4] * at.c + x[5] * at.s);
    Matrix2 slopes;
    slopes << ks * at.force_by_theta[0] - gamma * (a + e * b) - mu * (b - e * a),
        ks * at.force_by_phi[0], ks * at.force_by_theta[1] + gamma * (b + e * a) + mu * (a - e * b),
        ks * at.force_by_phi[1];
    return slopes;
  }

  Real w0_;  ///< [rad/s]
  Real d_;   ///< xi0 w0 [1/s]
  IntervalNoise noise_;
  State x_;
  Matrix7 p_;
};

}  // namespace cvg
