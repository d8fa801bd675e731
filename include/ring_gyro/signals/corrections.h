#pragma once

#include <Eigen/Core>

#include "ring_gyro/common/angle_harmonics.h"
#include "ring_gyro/common/parameter_table.h"
#include "ring_gyro/signals/envelope.h"

namespace cvg {

/// Deviation of the path from the commanded drive to the measured motion from the factor ks. This
/// form contains every possible linear error:
///
///     e^{-i phase} [I + (mismatch + i phase_mismatch) S1 + (skew + i phase_skew) S2
///                   + (rotation + i rotation_phase) J],
///     S1 = diag(1, -1), S2 = offdiag(1, 1), J = [[0, 1], [-1, 0]].
///
/// Drive and pick-off both contribute to each number; only their product acts on the loops.
struct DrivePath {
  double phase = 0.0;           ///< delay of both axes [rad]
  double mismatch = 0.0;        ///< half the relative gain difference of x and y
  double skew = 0.0;            ///< cross gain, symmetric
  double rotation = 0.0;        ///< of the drive against the pick-off, positive as J [rad]
  double phase_mismatch = 0.0;  ///< half the phase by which x leads y [rad]
  double phase_skew = 0.0;      ///< cross phase, symmetric [rad]
  double rotation_phase = 0.0;  ///< cross phase, antisymmetric [rad]

  Eigen::Matrix2cd matrix() const;
  /// The path whose matrix is a multiple of `matrix`, which must not be singular.
  static DrivePath of(const Eigen::Matrix2cd& matrix);
};

/// What a calibration found and the loops correct, each part with its own switch.
///
/// In the order of the signal path: the cubic of the pick-off is undone on the envelope; the loops
/// see the corrected orbit; steering cancels the drift that depends on the angle only; velocity
/// feedback cancels the damping mismatch (35); the drive is multiplied by the inverse of its path;
/// the angle map makes the output angle from theta. docs/calibration.md gives the reason for this
/// order.
struct Corrections {
  bool correct_pickoff = true;
  bool correct_phase = true;           ///< DrivePath::phase
  bool correct_drive_gains = true;     ///< DrivePath::mismatch, skew, rotation
  bool correct_phase_mismatch = true;  ///< the phases of these three
  bool cancel_damping = true;
  bool cancel_drift = true;
  bool map_angle = true;

  double pickoff_cubic = 0.0;  ///< a displacement x reads x (1 + cubic x^2) [1/V^2]
  DrivePath drive_path;
  double gamma1 = 0.0;       ///< damping mismatch to be cancelled
  double gamma2 = 0.0;       ///< the same across the axes
  AngleHarmonics drift;      ///< rate of the pattern while the case is at rest [rad/s]
  AngleHarmonics angle_map;  ///< output angle minus theta [rad]

  /// Envelope [V] of the motion from the measured envelope X (1 + 3/4 cubic |X|^2), per axis.
  Envelope undistorted(const Envelope& measured) const;
  /// Inverse of the switched-on parts of the drive path.
  Eigen::Matrix2cd driveCorrection() const;
  /// Rate of steering that cancels the drift at this pattern angle [rad/s].
  double driftAt(double theta) const { return cancel_drift ? drift.at(theta) : 0.0; }
  /// Pattern angle without the errors of the pick-off [rad].
  double outputAngle(double theta) const { return map_angle ? theta + angle_map.at(theta) : theta; }
  /// Its derivative with respect to theta.
  double outputSlope(double theta) const {
    return map_angle ? 1.0 + angle_map.slopeAt(theta) : 1.0;
  }

  void declare(ParameterTable& table);
};

}  // namespace cvg
