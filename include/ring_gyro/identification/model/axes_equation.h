#pragma once

#include "ring_gyro/common/lanes.h"
#include "ring_gyro/common/small_algebra.h"
#include "ring_gyro/identification/model/averaged_model.h"
#include "ring_gyro/identification/model/axes_dynamics.h"

namespace cvg {

/// r = (a, b) after a midpoint step, and the derivatives of exactly that step.
struct AxesStepResult {
  Vector2 axes;             ///< [V]
  Matrix2 by_axes;          ///< T: with respect to r before the step
  Matrix2 rate_by_angles;   ///< of the rate before the step, with respect to (theta, phi)
  Matrix2x5 by_parameters;  ///< G: with respect to gamma1, gamma2, mu1, mu2, ks
};

/// r' = M r + ks f for r = (a, b): equations (16)(17) of one device at given angles and inputs,
/// with all derivatives (docs/filter.md, section 1). gc, ms: gamma along the axes, mu across them.
struct AxesEquation {
  const AxesDynamics<double>& at;
  const DeviceParameters& device;
  Matrix2 m;  ///< [1/s]
  Vector2 f;  ///< [V s]

  /// Both arguments must outlive this object.
  AxesEquation(const AxesDynamics<double>& dynamics, const DeviceParameters& parameters)
      : at(dynamics), device(parameters), f{at.f1.im, at.f2.re} {
    const AxesMatrix<double> entries = at.matrix(device);
    m = {Vector2{entries.aa, entries.ba}, Vector2{entries.ab, entries.bb}};
  }

  Vector2 rate(const Vector2& r) const { return m * r + device.drive_gain * f; }

  /// r' with respect to gc: (-d (a + e b), d (b + e a)).
  Vector2 byGamma(const Vector2& r) const { return Vector2{-at.d, at.d} * (r + at.e * swapped(r)); }
  /// r' with respect to ms: (K2 (b - e a), -K2 (a - e b)).
  Vector2 byMu(const Vector2& r) const { return Vector2{at.k2, -at.k2} * (swapped(r) - at.e * r); }
  /// r' with respect to theta and phi. The derivatives of F1 and F2 by theta are F2 and -F1; those
  /// of E F1 and E F2 by phi are -i times them.
  Matrix2 byAngles(const Vector2& r) const {
    const double gc_slope = 2.0 * (device.gamma2 * at.c - device.gamma1 * at.s);
    const double ms_slope = -2.0 * (device.mu1 * at.c + device.mu2 * at.s);
    const Vector2 turned = device.drive_gain * Vector2{at.f2.im, -at.f1.re};
    return {turned + gc_slope * byGamma(r) + ms_slope * byMu(r), swapped(turned)};
  }
  /// The columns (33), from the derivatives with respect to gc, ms and ks:
  /// gc = gamma1 c + gamma2 s, ms = mu2 c - mu1 s.
  Matrix2x5 byParameters(const Vector2& by_gamma, const Vector2& by_mu,
                         const Vector2& by_drive_gain) const {
    const FourLanes angles = {at.c, at.s, -at.s, at.c};
    const auto row = [&](int axis) {
      return Vector5(angles * FourLanes{by_gamma[axis], by_gamma[axis], by_mu[axis], by_mu[axis]},
                     by_drive_gain[axis]);
    };
    return {row(0), row(1)};
  }

  /// Midpoint step over `h` [s]: r + h r'(r_mid) with r_mid = r + h/2 r'(r).
  AxesStepResult step(const Vector2& r, double h) const {
    const Vector2 middle = r + 0.5 * h * rate(r);
    // What a derivative or term P of the rate becomes in the step: h (P(r_mid) + h/2 M P(r)).
    const auto ofStep = [&](const Vector2& at_middle, const Vector2& at_start) {
      return Vector2(h * (at_middle + 0.5 * h * (m * at_start)));
    };
    const Matrix2 change = {ofStep(m.first, m.first), ofStep(m.second, m.second)};
    const Vector2 by_drive_gain = ofStep(f, f);
    AxesStepResult result;
    result.axes = r + (change * r + device.drive_gain * by_drive_gain);
    result.by_axes = change + 1.0;
    result.by_parameters = byParameters(ofStep(byGamma(middle), byGamma(r)),
                                        ofStep(byMu(middle), byMu(r)), by_drive_gain);
    result.rate_by_angles = byAngles(r);
    return result;
  }
};

}  // namespace cvg
