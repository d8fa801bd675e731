#pragma once

#include "ring_gyro/signals/block_stamp.h"
#include "ring_gyro/signals/envelope.h"
#include "ring_gyro/signals/loop_status.h"

namespace cvg {

/// Drive envelopes [V] by purpose; their sum is the commanded drive.
struct DriveContributions {
  Envelope sustain = Envelope::Zero();
  Envelope quadrature = Envelope::Zero();
  Envelope steering = Envelope::Zero();
  Envelope compensation = Envelope::Zero();

  Envelope total() const { return sustain + quadrature + steering + compensation; }
};

/// Velocity feedback that cancels damping mismatch: f = [[g1, g2],[g2, -g1]] v, equation (35) with
/// the sign corrected; g = 2 xi0 w0 gamma / ks [s].
struct DampingCompensation {
  double gain1 = 0.0;  ///< [V / (V/s)]
  double gain2 = 0.0;  ///< [V / (V/s)]
};

/// Drive and gains that acted in one block, [stamp.end - duration, stamp.end).
struct ControlGains {
  BlockStamp stamp;
  double reference_frequency = 0.0;  ///< w of the NCO [rad/s]
  double reference_phase = 0.0;      ///< of the NCO at the block start [rad]
  double beta = 0.0;   ///< sustain gain, drive volt per V/s [s]; 0 while a is too small
  double alpha = 0.0;  ///< quadrature gain, drive volt per displacement volt
  /// Steering that acted, given as the equal rotation k Om: if positive, theta falls [rad/s].
  double virtual_rate = 0.0;
  DampingCompensation compensation;
  DriveContributions drive;
  LoopStatus status;
};

}  // namespace cvg
