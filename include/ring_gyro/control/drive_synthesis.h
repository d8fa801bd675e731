#pragma once

#include <Eigen/Core>

#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace cvg {

/// What the drive is made from.
struct DriveGains {
  double sustain_force = 0.0;  ///< w beta a [V], along the major axis
  double alpha = 0.0;          ///< quadrature gain, volt per volt
  double virtual_rate = 0.0;   ///< steer as a rotation k Om of this would [rad/s]
  DampingCompensation compensation;
};

/// Velocity envelope w R(theta) [a; -i b] [V/s], equation (27): of the locked orbit, phi = -pi/2,
/// because the drive's phase is the NCO's and the phase-locked loop turns the NCO.
Eigen::Vector2cd velocityEnvelope(const Orbit& orbit, double reference_frequency);

/// Drive envelopes (20)(28)(35) for the orbit as it will be when they act.
///
/// sustain beta v, quadrature alpha J u, steering (2 Os / ks) J v, compensation [[g1,g2],[g2,-g1]]
/// v, with J = [[0,1],[-1,0]], u displacement and v velocity. orbit.phi is not used: the envelope
/// is relative to the NCO; AveragedModel says what it does at any phi. `drive_gain`: ks as the
/// loops know it [1/s^2].
DriveContributions synthesizeDrive(const Orbit& orbit, const DriveGains& gains,
                                   double reference_frequency, double drive_gain);

}  // namespace cvg
