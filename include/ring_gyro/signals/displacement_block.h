#pragma once

#include <cstdint>

#include "ring_gyro/common/aligned_vector.h"
#include "ring_gyro/signals/block_stamp.h"

namespace cvg {

/// One block of converter samples of both axes, sample j taken at block start + j / sample_rate.
struct DisplacementBlock {
  BlockStamp stamp;
  /// The drive that acted in this block: the DriveCommand that answered this sequence.
  /// Meaningless while `driven` is false (nothing has been commanded yet).
  std::uint64_t drive_answers_sequence = 0;
  bool driven = false;
  double reference_phase = 0.0;         ///< of the NCO at the first sample [rad]
  double reference_frequency = 0.0;     ///< of the NCO in this block [rad/s]
  std::uint32_t saturated_samples = 0;  ///< samples at the limit of the converter's range
  /// Drive samples that the drive's converter clipped to its range: the drive was not the commanded
  /// one.
  std::uint32_t clipped_drive_samples = 0;
  AlignedVector x;  ///< [V]
  AlignedVector y;  ///< [V]
};

}  // namespace cvg
