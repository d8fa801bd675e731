#pragma once

#include <Eigen/Core>

#include "ring_gyro/common/device_knowledge.h"
#include "ring_gyro/signals/envelope.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace cvg {

/// Mismatch and drive gain of a device: the parameters that are identified, in the order of (29).
struct DeviceParameters {
  double gamma1 = 0.0;
  double gamma2 = 0.0;
  double mu1 = 0.0;
  double mu2 = 0.0;
  double drive_gain = 0.0;  ///< ks [1/s^2]
};

/// Known inputs of the averaged model at one moment.
struct AveragedInput {
  Envelope drive = Envelope::Zero();  ///< total envelope [V]
  double reference_frequency = 0.0;   ///< w [rad/s]
  double pattern_rate = 0.0;          ///< measured theta', for the terms of second order [rad/s]
  double rotation_rate = 0.0;         ///< k Om [rad/s]
};

/// Rates of change of an orbit.
struct OrbitRates {
  double a = 0.0;      ///< [V/s]
  double b = 0.0;      ///< [V/s]
  double theta = 0.0;  ///< [rad/s]
  double phi = 0.0;    ///< [rad/s]
};

/// Rates of (a, b) and their derivatives, row 0: a, row 1: b.
struct AxesRates {
  Eigen::Vector2d rate;                       ///< [V/s]
  Eigen::Matrix2d by_axes;                    ///< with respect to (a, b)
  Eigen::Matrix2d by_angles;                  ///< with respect to (theta, phi)
  Eigen::Matrix<double, 2, 5> by_parameters;  ///< with respect to gamma1, gamma2, mu1, mu2, ks
};

/// (a, b) after a step and the derivatives of exactly that step, row 0: a, row 1: b.
struct AxesStep {
  Eigen::Vector2d axes;                       ///< [V]
  Eigen::Matrix2d by_axes;                    ///< with respect to (a, b) before the step
  Eigen::Matrix2d rate_by_angles;             ///< of the rate, with respect to (theta, phi)
  Eigen::Matrix<double, 2, 5> by_parameters;  ///< with respect to gamma1, gamma2, mu1, mu2, ks
};

/// A drive that is held for a block and then steps by S makes the slow envelope jump by
/// ks / (4 w^2) (S - S* e^{-2 i psi}), psi: phase of the NCO at the step (docs/derivation.md,
/// section 8). This is the constant drive [V] that moves the envelope by the same amount in the
/// `duration` [s] after the step from `before` to `after`; add it to the drive. The effect matters
/// where the block is a whole number of half cycles, because then the images add up.
Envelope driveStep(const Envelope& before, const Envelope& after, double reference_phase,
                   double reference_frequency, double duration);

/// The slow model (16)-(24): how the orbital elements change when averaged over a cycle.
///
/// The coefficients are those of the exact envelope equation to first order in the slow rates: the
/// w0 printed as the factor of mu is w0^2 / w here, and w0 - w is (w0^2 - w^2) / (2 w). At w = w0
/// this is the printed model (docs/derivation.md). a' and b' also have the second-order terms of a
/// pattern that turns at theta' (section 8), of relative size theta' / w; the rates of the angles
/// do not. The rule for drives is the same at any phi.
class AveragedModel {
 public:
  /// f0 and Q of `device` are those of the ideal ring; throws std::invalid_argument unless both are
  /// above zero.
  explicit AveragedModel(const DeviceKnowledge& device);

  /// All four rates. The orbit must not be a circle (a^2 = b^2): there theta' is not defined.
  OrbitRates rates(const Orbit& orbit, const DeviceParameters& device,
                   const AveragedInput& input) const;

  /// Rates of a and b with their analytic Jacobian, equations (30)-(33).
  AxesRates axesRates(const Orbit& orbit, const DeviceParameters& device,
                      const AveragedInput& input) const;

  /// Midpoint step of a and b over `duration` [s]; orbit.theta and orbit.phi are those of the
  /// middle of the step, input.drive is the mean over it. The error is
  /// (rate duration)^3 / 6, relative to what changes.
  AxesStep axesStep(const Orbit& orbit, const DeviceParameters& device, const AveragedInput& input,
                    double duration) const;

  /// Orbit after `duration` [s] with a drive that is constant relative to the NCO, in `steps`
  /// Runge-Kutta steps: a fast simulator.
  Orbit integrate(const Orbit& orbit, const DeviceParameters& device, const AveragedInput& input,
                  double duration, int steps) const;

  double angularFrequency() const { return angular_frequency_; }  ///< w0 [rad/s]
  double decayRate() const { return decay_rate_; }                ///< xi0 w0 [1/s]

 private:
  double angular_frequency_;
  double decay_rate_;
};

}  // namespace cvg
