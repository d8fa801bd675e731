#pragma once

#include <type_traits>

#include "ring_gyro/common/lanes.h"
#include "ring_gyro/common/pairs.h"
#include "ring_gyro/common/sine_cosine.h"
#include "ring_gyro/identification/model/averaged_step.h"
#include "ring_gyro/identification/model/parameter_lanes.h"

namespace cvg {

/// Sines and cosines of theta, phi and -2 psi of a step: of one, side by side, or of each in turn.
template <typename Real>
struct StepAngles;

template <>
struct StepAngles<double> {
  explicit StepAngles(const AveragedStep<double>& step) {
    const FourLanes angles = {step.theta, step.phi, step.image_angle, 0.0};
    FourLanes sine, cosine;
    sineCosine(angles, sine, cosine);
    theta_sine = sine[0], theta_cosine = cosine[0];
    phi_sine = sine[1], phi_cosine = cosine[1];
    image_sine = sine[2], image_cosine = cosine[2];
  }
  double theta_sine, theta_cosine, phi_sine, phi_cosine, image_sine, image_cosine;
};

template <>
struct StepAngles<Lanes> {
  explicit StepAngles(const AveragedStep<Lanes>& step) {
    const Lanes angle[3] = {step.theta, step.phi, step.image_angle};
    Lanes sine[3], cosine[3];
// Short code counts: it is seldom run, and then comes from far.
#pragma GCC unroll 1
    for (int i = 0; i < 3; ++i) sineCosine(angle[i], sine[i], cosine[i]);
    theta_sine = sine[0], theta_cosine = cosine[0];
    phi_sine = sine[1], phi_cosine = cosine[1];
    image_sine = sine[2], image_cosine = cosine[2];
  }
  Lanes theta_sine, theta_cosine, phi_sine, phi_cosine, image_sine, image_cosine;
};

/// Rates of a and b with respect to a and b [1/s].
template <typename Real>
struct AxesMatrix {
  Real aa, ab, ba, bb;
};

/// (a, b) after a step is (1 + transition) (a, b) + force.
template <typename Real>
struct AxesTransition {
  Real aa, ab, ba, bb;
  Real a_force, b_force;
};

/// a' and b' as what they are at given angles, equations (16)(17): linear in (a, b), in the
/// parameters and in the drive. `Real`: double, or Lanes for several steps.
template <typename Real>
struct AxesDynamics {
  double decay;   ///< xi0 w0 [1/s]
  Real coupling;  ///< w0^2 / (2 w) [rad/s]
  Real turning;   ///< theta' / (2 w)
  Real cosine;    ///< of 2 theta
  Real sine;
  // E F1 / (2 w) and E F2 / (2 w) with [F1; F2] = R(-theta) F, E = e^{-i phi} [V s].
  Real along_real, along_imaginary, across_real, across_imaginary;

  /// `angular_frequency`: w0 of the ideal ring [rad/s].
  AxesDynamics(double decay_rate, double angular_frequency, const AveragedStep<Real>& step)
      : decay(decay_rate) {
    const StepAngles<Real> angles(step);
    // The image of a component's step s: i (s - s* e^{-2 i psi}).
    const Real& ir = angles.image_cosine;
    const Real& ii = angles.image_sine;
    const Real xr = step.x_real -
                    (step.x_step_imaginary - (step.x_step_real * ii - step.x_step_imaginary * ir));
    const Real xi = step.x_imaginary +
                    (step.x_step_real - (step.x_step_real * ir + step.x_step_imaginary * ii));
    const Real yr = step.y_real -
                    (step.y_step_imaginary - (step.y_step_real * ii - step.y_step_imaginary * ir));
    const Real yi = step.y_imaginary +
                    (step.y_step_real - (step.y_step_real * ir + step.y_step_imaginary * ii));

    const Real& c = angles.theta_cosine;
    const Real& s = angles.theta_sine;
    const Real scale = 0.5 / step.reference_frequency;
    coupling = scale * (angular_frequency * angular_frequency);
    turning = scale * step.pattern_rate;
    cosine = c * c - s * s;
    sine = 2.0 * c * s;
    const Real along_r = c * xr + s * yr;
    const Real along_i = c * xi + s * yi;
    const Real across_r = c * yr - s * xr;
    const Real across_i = c * yi - s * xi;
    const Real er = scale * angles.phi_cosine;
    const Real ei = -(scale * angles.phi_sine);
    along_real = er * along_r - ei * along_i;
    along_imaginary = er * along_i + ei * along_r;
    across_real = er * across_r - ei * across_i;
    across_imaginary = er * across_i + ei * across_r;
  }

  /// One step in the place of several: what `mean` makes of the lanes of each number.
  template <typename Mean>
  AxesDynamics(const AxesDynamics<Lanes>& steps, const Mean& mean)
      : decay(steps.decay),
        coupling(mean(steps.coupling)),
        turning(mean(steps.turning)),
        cosine(mean(steps.cosine)),
        sine(mean(steps.sine)),
        along_real(mean(steps.along_real)),
        along_imaginary(mean(steps.along_imaginary)),
        across_real(mean(steps.across_real)),
        across_imaginary(mean(steps.across_imaginary)) {
    static_assert(std::is_same<Real, double>::value, "lanes are several steps");
  }

  AxesMatrix<Real> matrix(const DeviceParameters& device) const {
    const Real gamma = device.gamma1 * cosine + device.gamma2 * sine;
    const Real mu = coupling * (device.mu2 * cosine - device.mu1 * sine);
    const Real a_decay = decay * (1.0 + gamma);
    const Real b_decay = decay * (1.0 - gamma);
    return {-a_decay - turning * mu, mu - turning * a_decay,  //
            -mu - turning * b_decay, turning * mu - b_decay};
  }

  /// Of a midpoint step over `duration` [s].
  AxesTransition<Real> transition(const DeviceParameters& device, double duration) const {
    const AxesMatrix<Real> rates = matrix(device);
    const Real &aa = rates.aa, &ab = rates.ab, &ba = rates.ba, &bb = rates.bb;
    const double half = 0.5 * duration;
    const Real a_force = duration * device.drive_gain * along_imaginary;
    const Real b_force = duration * device.drive_gain * across_real;
    AxesTransition<Real> result;
    result.aa = duration * (aa + half * (aa * aa + ab * ba));
    result.ab = duration * (ab + half * (aa * ab + ab * bb));
    result.ba = duration * (ba + half * (ba * aa + bb * ba));
    result.bb = duration * (bb + half * (ba * ab + bb * bb));
    result.a_force = a_force + half * (aa * a_force + ab * b_force);
    result.b_force = b_force + half * (ba * a_force + bb * b_force);
    return result;
  }
};

/// (a, b) after a midpoint step, and the derivatives of exactly that step, row 0: a, row 1: b.
struct AxesStepPairs {
  TwoLanes axes;          ///< [V]
  Square by_axes;         ///< with respect to (a, b) before the step
  Square rate_by_angles;  ///< of the rate, with respect to (theta, phi)
  ParameterRows by_parameters;
};

/// Rates of (a, b), equations (16)(17): linear in (a, b), in the parameters and in the drive.
struct AxesRatePairs {
  const AxesDynamics<double>& at;
  const DeviceParameters& device;
  TwoLanes force;  ///< rate per ks
  Square by_axes;  ///< rate with respect to (a, b)

  AxesRatePairs(const AxesDynamics<double>& dynamics, const DeviceParameters& parameters)
      : at(dynamics), device(parameters), force{at.along_imaginary, at.across_real} {
    const AxesMatrix<double> rates = at.matrix(device);
    by_axes = {TwoLanes{rates.aa, rates.ba}, TwoLanes{rates.ab, rates.bb}};
  }

  TwoLanes rate(const TwoLanes& axes) const { return by_axes * axes + device.drive_gain * force; }

  // Damping and stiffness act on the motion, whose axes are not quite those of the envelope while
  // the pattern turns: on (a + e b, b + e a) and (a - e b, b - e a), e = theta' / (2 w).

  /// With respect to what gamma is along the axes.
  TwoLanes byGamma(const TwoLanes& axes) const {
    return TwoLanes{-at.decay, at.decay} * (axes + at.turning * swapped(axes));
  }
  /// With respect to what mu is across the axes.
  TwoLanes byMu(const TwoLanes& axes) const {
    return TwoLanes{at.coupling, -at.coupling} * (swapped(axes) - at.turning * axes);
  }
  /// With respect to (theta, phi). Turning the pattern turns F1 into F2 and F2 into -F1; turning
  /// phi multiplies both by -i.
  Square byAngles(const TwoLanes& axes) const {
    const double gamma_slope = 2.0 * (device.gamma2 * at.cosine - device.gamma1 * at.sine);
    const double mu_slope = -2.0 * (device.mu1 * at.cosine + device.mu2 * at.sine);
    const TwoLanes turned = device.drive_gain * TwoLanes{at.across_imaginary, -at.along_real};
    return {turned + gamma_slope * byGamma(axes) + mu_slope * byMu(axes), swapped(turned)};
  }

  /// Midpoint step over `duration` [s].
  AxesStepPairs step(const TwoLanes& axes, double duration) const {
    const double half = 0.5 * duration;
    const TwoLanes middle = axes + half * rate(axes);
    // Of a rate P it is h (P(middle) + h/2 M P(axes)).
    const auto ofStep = [&](const TwoLanes& at_middle, const TwoLanes& at_start) {
      return TwoLanes(duration * (at_middle + half * (by_axes * at_start)));
    };
    AxesStepPairs result;
    const Square change = {ofStep(by_axes.first, by_axes.first),
                           ofStep(by_axes.second, by_axes.second)};
    result.by_axes = change + diagonal(1.0, 1.0);
    const TwoLanes by_drive_gain = ofStep(force, force);
    result.axes = axes + (change * axes + device.drive_gain * by_drive_gain);
    const TwoLanes by_gamma = ofStep(byGamma(middle), byGamma(axes));
    const TwoLanes by_mu = ofStep(byMu(middle), byMu(axes));
    result.by_parameters = byParameters(by_gamma, by_mu, by_drive_gain);
    result.rate_by_angles = byAngles(axes);
    return result;
  }

  /// Derivatives with respect to the parameters, from those with respect to gamma along the axes,
  /// mu across them and ks.
  ParameterRows byParameters(const TwoLanes& by_gamma, const TwoLanes& by_mu,
                             const TwoLanes& by_drive_gain) const {
    const FourLanes angles = {at.cosine, at.sine, -at.sine, at.cosine};
    const auto row = [&](int axis) {
      return ParameterLanes(
          angles * FourLanes{by_gamma[axis], by_gamma[axis], by_mu[axis], by_mu[axis]},
          by_drive_gain[axis]);
    };
    return {row(0), row(1)};
  }

 private:
  static TwoLanes swapped(const TwoLanes& pair) { return TwoLanes{pair[1], pair[0]}; }
};

}  // namespace cvg
