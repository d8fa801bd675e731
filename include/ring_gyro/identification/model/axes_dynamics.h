#pragma once

#include <type_traits>

#include "ring_gyro/common/lanes.h"
#include "ring_gyro/common/sine_cosine.h"
#include "ring_gyro/common/small_algebra.h"
#include "ring_gyro/identification/model/averaged_step.h"

namespace cvg {

/// e^{i theta}, e^{i phi} and e^{-2 i psi} of a step. For one step the three are computed side by
/// side; for several steps they are computed one after the other, each for all steps.
template <typename Real>
struct StepPhasors;

template <>
struct StepPhasors<double> {
  explicit StepPhasors(const AveragedStep<double>& step) {
    const FourLanes angles = {step.theta, step.phi, step.image_angle, 0.0};
    FourLanes sine, cosine;
    sineCosine(angles, sine, cosine);
    theta = {cosine[0], sine[0]};
    phi = {cosine[1], sine[1]};
    image = {cosine[2], sine[2]};
  }
  Phasor<double> theta, phi, image;
};

template <>
struct StepPhasors<Lanes> {
  explicit StepPhasors(const AveragedStep<Lanes>& step) {
    const Lanes angle[3] = {step.theta, step.phi, step.image_angle};
    Lanes sine[3], cosine[3];
// Not unrolled: this code runs too seldom to stay in the instruction cache; short code is faster.
#pragma GCC unroll 1
    for (int i = 0; i < 3; ++i) sineCosine(angle[i], sine[i], cosine[i]);
    theta = {cosine[0], sine[0]};
    phi = {cosine[1], sine[1]};
    image = {cosine[2], sine[2]};
  }
  Phasor<Lanes> theta, phi, image;
};

/// The matrix M of a' and b' by its entries: a' = aa a + ab b, b' = ba a + bb b [1/s].
template <typename Real>
struct AxesMatrix {
  Real aa, ab, ba, bb;
};

/// (a, b) after a step is (1 + change) (a, b) + (a_force, b_force).
template <typename Real>
struct AxesTransition {
  AxesMatrix<Real> change;
  Real a_force, b_force;
};

/// The coefficients of equations (16)(17) at given angles and inputs, with the letters of
/// docs/derivation.md: its (C) and (D) with the terms in e of its section 8. The equations are
/// linear in (a, b), in the parameters and in the drive. AxesEquation makes the rates and their
/// derivatives of them. `Real`: double, or Lanes for several steps.
template <typename Real>
struct AxesDynamics {
  double d;  ///< xi0 w0 [1/s]
  Real k2;   ///< w0^2 / (2 w) [rad/s]
  Real e;    ///< theta' / (2 w)
  Real c;    ///< cos 2 theta
  Real s;    ///< sin 2 theta
  /// E F1 / (2 w) and E F2 / (2 w), with [F1; F2] = R(-theta) F and E = e^{-i phi} [V s].
  Phasor<Real> f1, f2;

  /// `decay_rate`: xi0 w0 [1/s], `w0`: of the ideal ring [rad/s].
  AxesDynamics(double decay_rate, double w0, const AveragedStep<Real>& step) : d(decay_rate) {
    const StepPhasors<Real> unit(step);
    // The drive, plus i (S - S* e^{-2 i psi}) for its change within the step.
    const Phasor<Real> fx = step.x + timesI(step.x_change - conjugate(step.x_change) * unit.image);
    const Phasor<Real> fy = step.y + timesI(step.y_change - conjugate(step.y_change) * unit.image);

    const Real half_period = 0.5 / step.reference_frequency;  // 1 / (2 w)
    k2 = half_period * (w0 * w0);
    e = half_period * step.pattern_rate;
    const Phasor<Real> twice = unit.theta * unit.theta;
    c = twice.re;
    s = twice.im;
    const Phasor<Real> lag = half_period * conjugate(unit.phi);
    f1 = lag * (unit.theta.re * fx + unit.theta.im * fy);
    f2 = lag * (unit.theta.re * fy - unit.theta.im * fx);
  }

  /// One step in place of several: each number is `mean` of its lanes.
  template <typename Mean>
  AxesDynamics(const AxesDynamics<Lanes>& steps, const Mean& mean)
      : d(steps.d),
        k2(mean(steps.k2)),
        e(mean(steps.e)),
        c(mean(steps.c)),
        s(mean(steps.s)),
        f1{mean(steps.f1.re), mean(steps.f1.im)},
        f2{mean(steps.f2.re), mean(steps.f2.im)} {
    static_assert(std::is_same<Real, double>::value, "lanes are several steps");
  }

  /// M of (C)(D), without the drive:
  ///   a' = -d (1 + gc) (a + e b) + K2 ms (b - e a)
  ///   b' = -d (1 - gc) (b + e a) - K2 ms (a - e b).
  AxesMatrix<Real> matrix(const DeviceParameters& device) const {
    const Real gc = device.gamma1 * c + device.gamma2 * s;
    const Real k2_ms = k2 * (device.mu2 * c - device.mu1 * s);
    const Real da = d * (1.0 + gc);
    const Real db = d * (1.0 - gc);
    return {-da - e * k2_ms, k2_ms - e * da,  //
            -k2_ms - e * db, e * k2_ms - db};
  }

  /// A midpoint step over `h` [s]: change = h M (1 + h M / 2), force = h ks (1 + h M / 2) f with
  /// f = (Im f1, Re f2).
  AxesTransition<Real> transition(const DeviceParameters& device, double h) const {
    const AxesMatrix<Real> m = matrix(device);
    const double half = 0.5 * h;
    const Real a_force = h * device.drive_gain * f1.im;
    const Real b_force = h * device.drive_gain * f2.re;
    return {{h * (m.aa + half * (m.aa * m.aa + m.ab * m.ba)),
             h * (m.ab + half * (m.aa * m.ab + m.ab * m.bb)),
             h * (m.ba + half * (m.ba * m.aa + m.bb * m.ba)),
             h * (m.bb + half * (m.ba * m.ab + m.bb * m.bb))},
            a_force + half * (m.aa * a_force + m.ab * b_force),
            b_force + half * (m.ba * a_force + m.bb * b_force)};
  }
};

}  // namespace cvg
