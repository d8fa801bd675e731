#pragma once

#include <Eigen/Core>

#include "ring_gyro/signals/envelope.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace cvg {

/// What the first blocks show before there is an estimate.
struct FirstLook {
  double amplitude = 0.0;   ///< mean of a [V]
  double drive_gain = 0.0;  ///< ks from the balance of drive and damping [1/s^2]
  double frequency = 0.0;   ///< f0 from the rate of phi; mu is neglected [Hz]
};

/// Gathers blocks for a first look; all must be usable, without a gap between them.
class FirstLookSum {
 public:
  /// `drive`: envelope that acted [V]; `reference_frequency`: w [rad/s].
  void add(const Orbit& orbit, const Envelope& drive, double reference_frequency);
  /// From the blocks so far, at least one, of `duration` [s] each, for a ring with this decay rate
  /// [1/s]. If the drive does not sustain the orbit, ks is zero, negative or not finite.
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
