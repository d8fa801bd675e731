#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>

#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace cvg {

/// Whether a block can be used for identification; if not, the first reason that applies. All
/// counts of blocks are by these reasons.
enum class BlockUse : std::uint8_t {
  kUsable,
  kNotFinite,       ///< a number that is not finite, or so large that a square could overflow
  kImpossible,      ///< an impossible number, such as a negative group delay
  kContradiction,   ///< a drive that is not the sum of its parts
  kOtherBlock,      ///< elements and gains of different blocks, or no stamp
  kWrongDuration,   ///< the block's duration is not that of the configuration
  kNoAmplitude,     ///< a is not above |b|: all zero, or no ellipse
  kInvalidSamples,  ///< as the status says
  kSaturated,       ///< converter or drive, as the status says
  kNotLocked,       ///< as the status says
  kNoFrequency,     ///< a reference frequency that is not above zero
  kGroupDelay,      ///< longer than BlockChain remembers
  kAfterBreak,      ///< the demodulator's memory still holds a block that cannot be used
};

/// Number of usable blocks, and of unusable ones for each reason.
struct BlockUseCounts {
  std::array<std::uint64_t, 13> blocks = {};

  void add(BlockUse use) { ++blocks[static_cast<std::size_t>(use)]; }
  std::uint64_t of(BlockUse use) const { return blocks[static_cast<std::size_t>(use)]; }
  std::uint64_t usable() const { return of(BlockUse::kUsable); }
  std::uint64_t unusable() const;
  /// The counts since `earlier`.
  BlockUseCounts operator-(const BlockUseCounts& earlier) const;
};
static_assert(static_cast<std::size_t>(BlockUse::kAfterBreak) + 1 ==
              std::tuple_size_v<decltype(BlockUseCounts::blocks)>);

/// Largest sum of the magnitudes of a block's numbers: above it a square could overflow later.
constexpr double kLargestBlock = 1e12;

/// The first reason against a block, judged by its own data only, without the blocks before it;
/// kUsable: there is none. `magnitudes`: sum of the magnitudes of all its numbers.
BlockUse useOf(const OrbitalElements& elements, const ControlGains& gains, double magnitudes,
               std::int64_t block_duration_ns);
BlockUse useOf(const OrbitalElements& elements, const ControlGains& gains,
               std::int64_t block_duration_ns);

}  // namespace cvg
