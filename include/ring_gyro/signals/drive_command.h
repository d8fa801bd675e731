#pragma once

#include <cstdint>

#include "ring_gyro/signals/envelope.h"

namespace cvg {

/// Commanded drive of one block: per axis f(t) = Re[envelope e^{i psi(t)}] with
/// psi(t) = reference_phase + reference_frequency (t - block start).
///
/// `answers_sequence` is the displacement block that the command was computed from; the command
/// acts in the next block.
struct DriveCommand {
  std::uint64_t answers_sequence = 0;
  double reference_phase = 0.0;          ///< phase of the NCO at the start of the block [rad]
  double reference_frequency = 0.0;      ///< [rad/s]
  Envelope envelope = Envelope::Zero();  ///< [V]
  /// Rate of the rate table under the gyroscope, in addition to its rotation profile; zero except
  /// in a calibration run [rad/s].
  double table_rate = 0.0;
  bool end_of_run = false;  ///< the answered block is the last one
};

}  // namespace cvg
