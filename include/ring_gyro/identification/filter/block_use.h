#pragma once

#include <cstdint>

#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace cvg {

/// Whether a block can be used to identify; if not, the first reason that holds.
enum class BlockUse : std::uint8_t {
  kUsable,
  kNotFinite,       ///< a number that is not finite, or so large that a square could overflow
  kImpossible,      ///< a number that cannot be, such as a negative group delay
  kContradiction,   ///< a drive that is not the sum of its parts
  kOtherBlock,      ///< elements and gains of different blocks, or no stamp
  kWrongDuration,   ///< of the block, against the configuration
  kNoAmplitude,     ///< a not above |b|: all zero, or no ellipse
  kInvalidSamples,  ///< as the status says
  kSaturated,       ///< converter or drive, as the status says
  kNotLocked,       ///< as the status says
  kNoFrequency,     ///< a reference frequency that is not above zero
  kGroupDelay,      ///< longer than what is remembered
};

/// Largest sum of the magnitudes of a block's numbers: beyond it a square could overflow later.
constexpr double kLargestBlock = 1e12;

/// The reason against a block, found one by one; kUsable: none, the group delay aside (BlockChain
/// knows what it remembers). `magnitudes`: sum of the magnitudes of all its numbers.
BlockUse useOf(const OrbitalElements& elements, const ControlGains& gains, double magnitudes,
               std::int64_t block_duration_ns);
BlockUse useOf(const OrbitalElements& elements, const ControlGains& gains,
               std::int64_t block_duration_ns);

}  // namespace cvg
