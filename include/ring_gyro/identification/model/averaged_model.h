#pragma once

#include <Eigen/Core>

#include "ring_gyro/common/device_knowledge.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace cvg {

/// Mismatch of a device and its gain: the parameters that are identified, in the order of (29).
struct DeviceParameters {
  double gamma1 = 0.0;
  double gamma2 = 0.0;
  double mu1 = 0.0;
  double mu2 = 0.0;
  double drive_gain = 0.0;  ///< ks [1/s^2]
};

/// Known inputs of the averaged model at one moment.
struct AveragedInput {
  Eigen::Vector2cd drive = Eigen::Vector2cd::Zero();  ///< total envelope [V]
  double reference_frequency = 0.0;                   ///< w [rad/s]
  double pattern_rate = 0.0;   ///< theta' as measured, for the terms of second order [rad/s]
  double rotation_rate = 0.0;  ///< k Om [rad/s]
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

/// Envelope [V] that a drive of `after` instead of `before` adds to the drive while it lasts for
/// `duration` [s] from the step on: what the step itself does to the slow envelope, spread evenly.
///
/// A drive that is held for a block and then steps has images around 2 w, which push on the other
/// way of turning; the step by F moves the slow envelope by ks / (4 w^2) (F - F* e^{-2 i psi}),
/// psi: phase of the NCO at the step. Matters where the block is a whole number of half cycles.
Eigen::Vector2cd driveStep(const Eigen::Vector2cd& before, const Eigen::Vector2cd& after,
                           double reference_phase, double reference_frequency, double duration);

/// The slow model (16)-(24): how the orbital elements change when averaged over a cycle.
///
/// Coefficients are those of the exact envelope equation to first order in the slow rates: the
/// printed w0 is w0^2 / w where it stands with mu, and w0 - w is (w0^2 - w^2) / (2 w). At w = w0
/// this is the printed model (docs/derivation.md). Of the second order (section 8), a' and b' have
/// what a pattern that turns at theta' adds, of relative size theta' / w; the rates of the angles
/// do not. Drives enter by one rule at any phi.
class AveragedModel {
 public:
  /// Of the ideal ring with the f0 and Q of `device`; throws std::invalid_argument unless both are
  /// above zero.
  explicit AveragedModel(const DeviceKnowledge& device);

  /// All four rates. The orbit must not be a circle (a^2 = b^2): theta has no rate there.
  OrbitRates rates(const Orbit& orbit, const DeviceParameters& device,
                   const AveragedInput& input) const;

  /// Rates of a and b with their analytic Jacobian, equations (30)-(33).
  AxesRates axesRates(const Orbit& orbit, const DeviceParameters& device,
                      const AveragedInput& input) const;

  /// Midpoint step of a and b over `duration` [s]; orbit.theta and orbit.phi are those of the
  /// middle of the step, input.drive the mean over it. Second order: the error is (rate duration)^3
  /// / 6 of what changes.
  AxesStep axesStep(const Orbit& orbit, const DeviceParameters& device, const AveragedInput& input,
                    double duration) const;

  /// Orbit after `duration` [s] at constant drive relative to the NCO, in `steps` Runge-Kutta
  /// steps: a fast simulator.
  Orbit integrate(const Orbit& orbit, const DeviceParameters& device, const AveragedInput& input,
                  double duration, int steps) const;

  double angularFrequency() const { return angular_frequency_; }  ///< w0 [rad/s]
  double decayRate() const { return decay_rate_; }                ///< xi0 w0 [1/s]

 private:
  double angular_frequency_;
  double decay_rate_;
};

}  // namespace cvg
