#pragma once

#include <Eigen/Core>

#include "ring_gyro/common/lanes.h"
#include "ring_gyro/identification/model/averaged_model.h"

namespace cvg {

/// Known inputs of a step of the averaged model. `Real`: double, or Lanes for several steps that
/// follow one another.
template <typename Real>
struct AveragedStep {
  // theta and phi, written one by one, stand apart, lest they are read as two (pairs.h).
  Real theta;                ///< measured, in the middle of the step [rad]
  Real pattern_rate;         ///< theta' [rad/s]
  Real phi;                  ///< as theta [rad]
  Real reference_frequency;  ///< w [rad/s]
  // Mean envelope of the drive [V].
  Real x_real, x_imaginary, y_real, y_imaginary;
  // What a drive that steps within adds to it (driveStep): the drive's step over 2 w duration [V]
  // and -2 psi [rad].
  Real x_step_real, x_step_imaginary, y_step_real, y_step_imaginary;
  Real image_angle;
};

/// A step whose drive is constant, or has had its driveStep() added.
inline AveragedStep<double> averagedStep(double theta, double phi, const AveragedInput& input) {
  AveragedStep<double> step = {};
  step.theta = theta;
  step.phi = phi;
  step.pattern_rate = input.pattern_rate;
  step.reference_frequency = input.reference_frequency;
  step.x_real = input.drive.x().real();
  step.x_imaginary = input.drive.x().imag();
  step.y_real = input.drive.y().real();
  step.y_imaginary = input.drive.y().imag();
  return step;
}

}  // namespace cvg
