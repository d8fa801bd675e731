#pragma once

#include "ring_gyro/signals/block_stamp.h"
#include "ring_gyro/signals/loop_status.h"

namespace cvg {

/// Orbit of the vibration over a cycle, equations (14)(15): an ellipse with major semi-axis a [V],
/// minor semi-axis b [V] (its sign is the sense of the motion), angle theta [rad] and phase phi
/// [rad]:
///
///     [X; Y] = e^{i phi} R(theta) [a; -i b],   x(t) = Re[X e^{i psi}].
///
/// (theta + pi, phi + pi) is the same motion; the branch with phi in (-pi, 0] is always used.
struct Orbit {
  double a = 0.0;
  double b = 0.0;
  double theta = 0.0;
  double phi = 0.0;
};

/// Measured orbit of one block, valid at stamp.end - group_delay.
struct OrbitalElements {
  BlockStamp stamp;
  double group_delay = 0.0;  ///< of the demodulator [s]
  Orbit orbit;               ///< theta unwrapped; phi in (-pi, 0]
  double theta_rate = 0.0;   ///< smoothed precession rate [rad/s]
  double angle = 0.0;        ///< theta after the angle map: the output of the gyroscope [rad]
  double angle_rate = 0.0;   ///< its rate, smoothed [rad/s]
  LoopStatus status;
};

}  // namespace cvg
