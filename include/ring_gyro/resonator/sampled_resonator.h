#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>

#include "ring_gyro/common/vector_kernels.h"
#include "ring_gyro/resonator/drive_force.h"
#include "ring_gyro/resonator/resonator_parameters.h"
#include "ring_gyro/resonator/ring_resonator.h"

namespace cvg {

/// Drive over one sample period: of an ideal modulator, or a value held from the converter.
struct SampleDrive {
  bool held = false;
  Eigen::Vector2d value = Eigen::Vector2d::Zero();  ///< held [V]
  DriveForce force;                                 ///< of the modulator
  ForcedMotion forced;                              ///< RingResonator::steadyMotion of `force`
  // Phase of the reference, a few turns at most [rad]. next_phase of one sample must be phase of
  // the next to the last bit, or rounding errors of the phase would add up.
  double phase = 0.0;       ///< at the sample
  double next_phase = 0.0;  ///< at the next one
};

/// Moves the state of a RingResonator sample by sample, with effects that are not in its exact
/// block solution: a held drive, cubic stiffness w0^2 c (x^2 + y^2) u, a drive that depends on the
/// displacement of its gap, f (1 + g u^2), and a rotation rate that varies.
///
/// The linear motion, forced by the drive, is exact. The other effects are integrated on top of it
/// by a fourth-order integrating-factor Runge-Kutta step (Lawson). Without them the step is exact.
class SampledResonator {
 public:
  /// `gap_cubic`: g [1/V^2].
  SampledResonator(const ResonatorParameters& parameters, double gap_cubic, double sample_period);

  /// Takes the linear part at the present conditions of `resonator` (always the same one).
  void setLinear(const RingResonator& resonator);

  /// Whether the motion is linear while the rate is constant.
  bool isLinear() const { return parameters_.cubic_stiffness == 0.0 && gap_cubic_ == 0.0; }
  /// Whether moveHeld() can be used while the rate is constant.
  bool canMoveHeld() const { return parameters_.cubic_stiffness == 0.0; }

  /// One sample period from `time` [s]; `extra_rate(t)` [rad/s] is the rate of the case minus the
  /// rate set in the resonator.
  Eigen::Vector4d step(const Eigen::Vector4d& state, const SampleDrive& drive, double time,
                       const std::function<double(double)>& extra_rate) const;

  /// `count` sample periods under the held drives `drive_x`, `drive_y` [V]; moves `state` and gives
  /// the displacements at the samples, delayed by `delays` [rad] of w0. Linear motion is exact.
  /// The effect of the gap on the drive is integrated along the linear motion of each sample period
  /// by Gauss' rule. In that time it moves the ring by about 1e-7 of the orbit, which is too small
  /// to change the effect itself.
  void moveHeld(Eigen::Vector4d& state, const double* drive_x, const double* drive_y,
                std::size_t count, const Eigen::Vector2d& delays, double* x, double* y) const;

 private:
  // With two steps per sample a cubic stiffness that shifts f0 by 1e-4 has an error below 1e-7 in a
  // second.
  static constexpr int kSubsteps = 2;

  Eigen::Vector4d substep(const Eigen::Vector4d& state, const SampleDrive& drive, double phase,
                          double next_phase, double time,
                          const std::function<double(double)>& extra_rate) const;
  void setGapNodes(const RingResonator& resonator,
                   const Eigen::Matrix<double, 4, 2>& rest_per_volt);
  Eigen::Vector4d rest(const Eigen::Vector4d& state, double extra_rate,
                       const Eigen::Vector2d& volts) const;

  ResonatorParameters parameters_;
  double gap_cubic_;
  double drive_gain_;
  double period_;                          // [s]
  double step_;                            // [s]
  std::uint64_t taken_conditions_ = 0;     // conditionChanges() of the resonator at setLinear()
  Eigen::Matrix4d half_;                   // e^{A h/2} of a step h
  Eigen::Matrix<double, 4, 2> held_half_;  // response to a held drive over h/2
  Eigen::Matrix4d whole_;                  // the same over a sample period
  Eigen::Matrix<double, 4, 2> held_whole_;
  GapNodes gap_nodes_;  // of moveHeld
};

}  // namespace cvg
