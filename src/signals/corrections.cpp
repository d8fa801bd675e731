#include "ring_gyro/signals/corrections.h"

#include <Eigen/LU>
#include <cmath>
#include <complex>

namespace cvg {

using Complex = std::complex<double>;

Eigen::Matrix2cd DrivePath::matrix() const {
  const Complex along(mismatch, phase_mismatch);
  const Complex across(skew, phase_skew);
  const Complex turned(rotation, rotation_phase);
  Eigen::Matrix2cd path;
  path << 1.0 + along, across + turned, across - turned, 1.0 - along;
  return std::polar(1.0, -phase) * path;
}

DrivePath DrivePath::of(const Eigen::Matrix2cd& matrix) {
  const Complex common = 0.5 * matrix.trace();
  const Complex along = 0.5 * (matrix(0, 0) - matrix(1, 1)) / common;
  const Complex across = 0.5 * (matrix(0, 1) + matrix(1, 0)) / common;
  const Complex turned = 0.5 * (matrix(0, 1) - matrix(1, 0)) / common;
  DrivePath path;
  path.phase = -std::arg(common);
  path.mismatch = along.real();
  path.phase_mismatch = along.imag();
  path.skew = across.real();
  path.phase_skew = across.imag();
  path.rotation = turned.real();
  path.rotation_phase = turned.imag();
  return path;
}

Envelope Corrections::undistorted(const Envelope& measured) const {
  if (!correct_pickoff || pickoff_cubic == 0.0) return measured;
  // Newton's steps for the amplitude r of the motion: r + 3/4 cubic r^3 = measured amplitude.
  constexpr int kSteps = 6;
  const double cubic = 0.75 * pickoff_cubic;
  Envelope envelope = measured;
  for (Complex& axis : envelope) {
    const double size = std::abs(axis);
    if (size == 0.0) continue;
    double motion = size;
    for (int step = 0; step < kSteps; ++step) {
      motion -= (motion + cubic * motion * motion * motion - size) /
                (1.0 + 3.0 * cubic * motion * motion);
    }
    axis *= motion / size;
  }
  return envelope;
}

Eigen::Matrix2cd Corrections::driveCorrection() const {
  DrivePath path = drive_path;
  if (!correct_phase) path.phase = 0.0;
  if (!correct_drive_gains) path.mismatch = path.skew = path.rotation = 0.0;
  if (!correct_phase_mismatch) path.phase_mismatch = path.phase_skew = path.rotation_phase = 0.0;
  return path.matrix().inverse();
}

void Corrections::declare(ParameterTable& table) {
  table.flag("correct_pickoff", correct_pickoff, "undo the cubic of the pick-off")
      .flag("correct_phase", correct_phase, "advance the drive by drive_phase")
      .flag("correct_drive_gains", correct_drive_gains,
            "multiply the drive by the inverse of mismatch, skew and rotation")
      .flag("correct_phase_mismatch", correct_phase_mismatch,
            "multiply the drive by the inverse of their phases")
      .flag("cancel_damping", cancel_damping, "velocity feedback against gamma1 and gamma2")
      .flag("cancel_drift", cancel_drift, "steer against the drift that depends on the angle")
      .flag("map_angle", map_angle, "apply the angle map to the output angle")
      .number("pickoff_cubic", pickoff_cubic, "1/V^2", Range::between(-0.3, 0.3),
              "a displacement x reads x (1 + pickoff_cubic x^2)")
      .number("drive_phase", drive_path.phase, "rad", Range::between(-1.5, 1.5),
              "delay of the path from drive to measured motion, both axes")
      .number("drive_mismatch", drive_path.mismatch, "1", Range::between(-0.5, 0.5),
              "half the relative gain difference of x and y in that path")
      .number("drive_skew", drive_path.skew, "1", Range::between(-0.5, 0.5),
              "symmetric cross gain in that path")
      .number("drive_rotation", drive_path.rotation, "rad", Range::between(-0.5, 0.5),
              "antisymmetric cross gain: the drive turned against the pick-off")
      .number("phase_mismatch", drive_path.phase_mismatch, "rad", Range::between(-0.5, 0.5),
              "half the phase by which x leads y in that path")
      .number("phase_skew", drive_path.phase_skew, "rad", Range::between(-0.5, 0.5),
              "symmetric cross phase in that path")
      .number("rotation_phase", drive_path.rotation_phase, "rad", Range::between(-0.5, 0.5),
              "antisymmetric cross phase in that path")
      .number("gamma1", gamma1, "1", Range::between(-0.5, 0.5),
              "damping mismatch along the axes that is cancelled from the start")
      .number("gamma2", gamma2, "1", Range::between(-0.5, 0.5),
              "damping mismatch across the axes that is cancelled from the start")
      .number("drift_constant", drift.constant, "rad/s", Range::between(-10.0, 10.0),
              "drift of the pattern that does not depend on the angle")
      .numbers("drift_cosine", drift.cosine, "rad/s", Range::between(-10.0, 10.0),
               "drift of the pattern with cos(n theta), n = 1, 2, ...")
      .numbers("drift_sine", drift.sine, "rad/s", Range::between(-10.0, 10.0),
               "drift of the pattern with sin(n theta), n = 1, 2, ...")
      .numbers("angle_map_cosine", angle_map.cosine, "rad", Range::between(-0.5, 0.5),
               "output angle minus theta, with cos(n theta), n = 1, 2, ...")
      .numbers("angle_map_sine", angle_map.sine, "rad", Range::between(-0.5, 0.5),
               "output angle minus theta, with sin(n theta), n = 1, 2, ...");
}

}  // namespace cvg
