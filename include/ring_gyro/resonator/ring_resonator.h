#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstdint>

#include "ring_gyro/common/vector_kernels.h"
#include "ring_gyro/resonator/drive_force.h"
#include "ring_gyro/resonator/resonator_parameters.h"

namespace cvg {

/// A phasor-modulated signal pair over one block: the sample at time s after the block start is
/// Re[e^{i w_ref s} sum_k coefficient_k (s / duration)^k + second e^{i w_2 s}] + constant, to 1e-13
/// of the motion. The last two terms are the response to the drive's square; zero without it.
struct BlockMotion {
  PhasorSeries series;               ///< coefficients of both axes [V]
  double reference_frequency = 0.0;  ///< w_ref [rad/s]
  double duration = 0.0;             ///< [s]
  Eigen::Vector2d constant = Eigen::Vector2d::Zero();
  Eigen::Vector2cd second = Eigen::Vector2cd::Zero();
  double second_frequency = 0.0;  ///< w_2, twice that of the drive [rad/s]
  std::complex<double> end_turn;  ///< e^{i psi} of the drive's reference at the end
};

/// The two modes of the ring as a linear system, solved exactly between drive updates.
///
/// With M = [[1+m1, m2],[m2, 1-m1]] and C = 2 xi0 w0 G - 2 k Om J the equation u'' + C u' + w0^2 M
/// u = ks f has the solution u(t) = Re[e^{S t} z + X_p e^{i psi}], where the 2x2 complex solvent S
/// obeys S^2 + C S + w0^2 M = 0 (its conjugate is the other solvent) and X_p is the steady response
/// to the drive phasor. The responses to a constant drive and to the second harmonic are added in
/// the same way. D = S - i w0 is small, so e^{D s} is a short power series over a block.
class RingResonator {
 public:
  explicit RingResonator(const ResonatorParameters& parameters);

  /// Displacements and velocities [V, V, V/s, V/s].
  const Eigen::Vector4d& state() const { return state_; }
  void setState(const Eigen::Vector4d& state) { state_ = state; }
  void addToState(const Eigen::Vector4d& kick) { state_ += kick; }

  /// Sets the rate of the case [rad/s] and the temperature deviation [K] from now on.
  void setConditions(double rotation_rate, double temperature);
  /// Counts the changes of the conditions, from 1.
  std::uint64_t conditionChanges() const { return condition_changes_; }

  /// Motion over the next `duration` [s] under the drive whose steady motion is `forced`, starting
  /// at the reference phase [rad]; the state moves to the end of this time.
  /// Throws std::domain_error when the drive is so far from the resonance (or the block so long)
  /// that the series does not converge.
  const BlockMotion& propagate(const ForcedMotion& forced, double phase, double duration);
  /// The same under the drive at `frequency` [rad/s].
  const BlockMotion& propagate(const DriveForce& drive, double phase, double frequency,
                               double duration) {
    return propagate(steadyMotion(drive, frequency), phase, duration);
  }

  /// Complex displacement whose real part is the state's displacement: the free vibration with
  /// velocity and displacement of `state` (used for the true orbital elements).
  Eigen::Vector2cd freeEnvelope(const Eigen::Vector4d& state) const;

  /// Steady response [V] to the drive phasor at `frequency` [rad/s].
  Eigen::Vector2cd steadyResponse(const Eigen::Vector2cd& drive, double frequency) const;
  /// Steady response to all harmonics of a drive.
  ForcedMotion steadyMotion(const DriveForce& drive, double frequency) const;

  /// Complex displacement at the present state, split into free and forced motion: the slow
  /// envelope times e^{i psi}, free of 2 w ripple and of the response to the drive's square.
  /// `turn`: e^{i psi} at the state.
  Eigen::Vector2cd analyticDisplacement(const ForcedMotion& forced,
                                        const std::complex<double>& turn) const;

  /// Matrix e^{A t} that moves the undriven state by a time t [s] of a few samples.
  Eigen::Matrix4d flow(double time) const;
  /// Displacement per volt of a constant drive.
  Eigen::Matrix2d compliance() const;
  /// D = S - i w0 [1/s]: the free envelope relative to e^{i w0 t} is proportional to e^{D t}.
  const Eigen::Matrix2cd& slowMotion() const { return slow_; }
  double driveGain() const { return drive_gain_; }

 private:
  void solveSlowMotion();
  Eigen::Vector2cd expand(const Eigen::Vector2cd& free, const Eigen::Vector2cd& forced,
                          double drift);

  ResonatorParameters parameters_;
  double drive_gain_;
  double rotation_rate_ = 0.0;
  double temperature_ = 0.0;
  std::uint64_t condition_changes_ = 0;
  double angular_frequency_ = 0.0;     // w0 at the present temperature
  Eigen::Matrix2d damping_;            // C
  Eigen::Matrix2d stiffness_;          // w0^2 (M - 1)
  Eigen::Matrix2cd slow_;              // S - i w0
  Eigen::Matrix2d inverse_imaginary_;  // Im(S)^-1
  Eigen::Vector4d state_ = Eigen::Vector4d::Zero();
  double turned_duration_ = 0.0;  // of the block that ends with turn_ [s]
  std::complex<double> turn_;     // e^{i w0 duration} of the frame
  BlockMotion motion_;
};

}  // namespace cvg
