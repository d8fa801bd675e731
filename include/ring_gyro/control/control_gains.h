#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "ring_gyro/common/block_stamp.h"
#include "ring_gyro/demodulation/orbital_elements.h"

namespace cvg {

/// Why the numbers of a block were refused where they came in.
enum class Refusal : std::uint8_t {
  kNone,
  kNotFinite,      ///< NaN, infinite, or so large that a square could overflow
  kImpossible,     ///< such as a negative group delay
  kContradiction,  ///< a total that is not the sum of its parts
};

/// What is known of one block; a usable block is locked and has none of the faults.
struct LoopStatus {
  bool amplitude_locked = false;     ///< a within 1 % of its setpoint for 50 ms
  bool quadrature_locked = false;    ///< |b| under 1 % of a for 50 ms
  bool phase_locked = false;         ///< phi within 0.5 deg of -90 deg for 50 ms
  bool invalid_samples = false;      ///< NaN or infinite samples, or wrong count: the loops coast
  bool converter_saturated = false;  ///< samples at the end of the converter's range
  bool drive_saturated = false;      ///< the drive that acted was scaled to its limit, or clipped
  Refusal refused = Refusal::kNone;  ///< the numbers of the block were left out; in no message

  bool locked() const { return amplitude_locked && quadrature_locked && phase_locked; }
  bool usable() const {
    return locked() && !invalid_samples && !converter_saturated && !drive_saturated &&
           refused == Refusal::kNone;
  }
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

/// Drive envelopes [V] by what they are for; their sum is what was commanded.
struct DriveContributions {
  Eigen::Vector2cd sustain = Eigen::Vector2cd::Zero();
  Eigen::Vector2cd quadrature = Eigen::Vector2cd::Zero();
  Eigen::Vector2cd steering = Eigen::Vector2cd::Zero();
  Eigen::Vector2cd compensation = Eigen::Vector2cd::Zero();

  Eigen::Vector2cd total() const { return sustain + quadrature + steering + compensation; }
};

/// Velocity feedback that cancels damping mismatch: f = [[g1, g2],[g2, -g1]] v, equation (35) with
/// the sign corrected; g = 2 xi0 w0 gamma / ks [s].
struct DampingCompensation {
  double gain1 = 0.0;  ///< [V / (V/s)]
  double gain2 = 0.0;  ///< [V / (V/s)]
};

/// What acted in one block, [stamp.end - duration, stamp.end).
struct ControlGains {
  BlockStamp stamp;
  double reference_frequency = 0.0;  ///< w of the NCO [rad/s]
  double reference_phase = 0.0;      ///< of the NCO at the block start [rad]
  double beta = 0.0;   ///< sustain gain, drive volt per V/s [s]; 0 while a is too small
  double alpha = 0.0;  ///< quadrature gain, drive volt per displacement volt
  double virtual_rate =
      0.0;  ///< steering that acted: as a rotation k Om of this, theta falls [rad/s]
  DampingCompensation compensation;
  DriveContributions drive;
  LoopStatus status;
};

}  // namespace cvg
