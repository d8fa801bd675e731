#pragma once

#include "ring_gyro/common/lanes.h"
#include "ring_gyro/common/small_algebra.h"
#include "ring_gyro/identification/model/averaged_model.h"

namespace cvg {

/// Known inputs of one step of the averaged model. `Real`: double, or Lanes for several steps side
/// by side.
template <typename Real>
struct AveragedStep {
  // theta and phi are not next to each other, so that the compiler does not load them as one
  // register after they were written one by one (small_algebra.h).
  Real theta = {};                ///< measured, in the middle of the step [rad]
  Real pattern_rate = {};         ///< theta' [rad/s]
  Real phi = {};                  ///< measured, in the middle of the step [rad]
  Real reference_frequency = {};  ///< w [rad/s]
  Phasor<Real> x, y;              ///< mean envelope F of the drive [V]
  // A drive that changes by S within the step adds i (S - S* e^{-2 i psi}) / (2 w duration) to its
  // mean (driveStep(); docs/derivation.md, section 8).
  Phasor<Real> x_change, y_change;  ///< S / (2 w duration) [V]
  Real image_angle = {};            ///< -2 psi [rad]
};

/// A step whose drive is constant, or already has its driveStep() added.
inline AveragedStep<double> averagedStep(double theta, double phi, const AveragedInput& input) {
  AveragedStep<double> step;
  step.theta = theta;
  step.phi = phi;
  step.pattern_rate = input.pattern_rate;
  step.reference_frequency = input.reference_frequency;
  step.x = phasor(input.drive.x());
  step.y = phasor(input.drive.y());
  return step;
}

}  // namespace cvg
