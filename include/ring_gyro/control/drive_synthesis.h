#pragma once

#include <Eigen/Core>

#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/envelope.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace cvg {

/// The quantities from which the drive is computed.
struct DriveGains {
  double sustain_force = 0.0;  ///< w beta a [V], along the major axis
  double alpha = 0.0;          ///< quadrature gain, volt per volt
  double virtual_rate = 0.0;   ///< steering, as the equal rotation k Om [rad/s]
  DampingCompensation compensation;
};

/// Velocity envelope w R(theta) [a; -i b] [V/s], equation (27), of the locked orbit, phi = -pi/2:
/// the drive has the phase of the NCO, and the phase-locked loop keeps the NCO locked to the
/// motion.
Envelope velocityEnvelope(const Orbit& orbit, double reference_frequency);

/// Drive envelopes (20)(28)(35) for the orbit at the time when they act.
///
/// sustain beta v, quadrature alpha J u, steering (2 Os / ks) J v, compensation [[g1,g2],[g2,-g1]]
/// v, with J = [[0,1],[-1,0]], u displacement and v velocity. orbit.phi is not used, because the
/// envelope is relative to the NCO; AveragedModel gives the effect at any phi. `drive_gain`: ks as
/// the loops assume it [1/s^2].
DriveContributions synthesizeDrive(const Orbit& orbit, const DriveGains& gains,
                                   double reference_frequency, double drive_gain);

}  // namespace cvg
