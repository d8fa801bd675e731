#pragma once

#include <Eigen/Core>
#include <functional>

#include "ring_gyro/resonator/resonator_parameters.h"
#include "ring_gyro/resonator/ring_resonator.h"

namespace ring_gyro {

/// Drive over one sample period: an ideal phasor, or a value held from the converter.
struct SampleDrive {
  bool held = false;
  Eigen::Vector2d value = Eigen::Vector2d::Zero();       ///< held [V]
  Eigen::Vector2cd envelope = Eigen::Vector2cd::Zero();  ///< of the phasor [V]
  double phase = 0.0;      ///< of the phasor at the sample, a few turns at most [rad]
  double frequency = 0.0;  ///< of the phasor [rad/s]
};

/// Moves the state of a RingResonator sample by sample, with what its exact block solution leaves
/// out: cubic stiffness w0^2 c (x^2 + y^2) u and a rotation rate that varies.
///
/// The linear motion, forced by the drive, is exact; the rest is integrated on top of it by a
/// fourth-order integrating-factor Runge-Kutta step (Lawson). Without that rest it is exact.
class SampledResonator {
 public:
  SampledResonator(const ResonatorParameters& parameters, double sample_period);

  /// Takes the linear part at the conditions that `resonator` has now.
  void setLinear(const RingResonator& resonator);

  /// One sample period from `time` [s]; `extra_rate(t)` [rad/s] is what the rate of the case
  /// exceeds the one set in the resonator by.
  Eigen::Vector4d step(const RingResonator& resonator, const Eigen::Vector4d& state,
                       const SampleDrive& drive, double time,
                       const std::function<double(double)>& extra_rate) const;

 private:
  // Two steps a sample keep a cubic stiffness that shifts f0 by 1e-4 below 1e-7 in a second.
  static constexpr int kSubsteps = 2;

  Eigen::Vector4d substep(const Eigen::Vector4d& state, const SampleDrive& drive,
                          const Eigen::Vector2cd& forced_begin, double time,
                          const std::function<double(double)>& extra_rate) const;
  Eigen::Vector4d halfFlow(const Eigen::Vector4d& state, const SampleDrive& drive,
                           const Eigen::Vector2cd& forced_begin,
                           const Eigen::Vector2cd& forced_end) const;
  Eigen::Vector4d rest(const Eigen::Vector4d& state, double extra_rate) const;

  ResonatorParameters parameters_;
  double step_;                            // [s]
  Eigen::Matrix4d half_;                   // e^{A h/2}
  Eigen::Matrix<double, 4, 2> held_half_;  // response to a held drive over h/2
};

}  // namespace ring_gyro
