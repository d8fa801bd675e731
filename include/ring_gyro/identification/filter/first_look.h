#pragma once

#include <Eigen/Core>

#include "ring_gyro/signals/orbital_elements.h"

namespace cvg {

/// What the first blocks tell before any estimate.
struct FirstLook {
  double amplitude = 0.0;   ///< mean of a [V]
  double drive_gain = 0.0;  ///< ks by the balance of drive and damping [1/s^2]
  double frequency = 0.0;   ///< f0 by the rate of phi, but for mu [Hz]
};

/// Gathers blocks for a first look; all must be usable and follow one another.
class FirstLookSum {
 public:
  /// `drive`: envelope that acted [V]; `reference_frequency`: w [rad/s].
  void add(const Orbit& orbit, const Eigen::Vector2cd& drive, double reference_frequency);
  /// Over the blocks so far, at least one, of `duration` [s], for a ring with this decay rate
  /// [1/s]; a ks that is not above zero and finite when the drive does not sustain the orbit.
  FirstLook look(double duration, double decay_rate) const;

 private:
  int blocks_ = 0;
  double amplitude_ = 0.0;
  double frequency_ = 0.0;
  double drive_ = 0.0;
  double first_phi_ = 0.0;
  double last_phi_ = 0.0;
};

}  // namespace cvg
