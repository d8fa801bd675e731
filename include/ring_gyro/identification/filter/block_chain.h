#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "ring_gyro/identification/filter/block_use.h"
#include "ring_gyro/identification/model/averaged_step.h"
#include "ring_gyro/identification/model/envelope_input.h"
#include "ring_gyro/signals/block_stamp.h"
#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/envelope.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace cvg {

/// Constant inputs between two moments at which elements are valid.
struct ChainSegment {
  double duration = 0.0;  ///< [s]
  double middle = 0.0;    ///< its middle, as a fraction of the way between the moments, 0 to 1
  EnvelopeInput input;
};

/// Pairs measured elements with the inputs that acted between them. Elements are valid one group
/// delay before the end of their block; the inputs are those of the blocks that acted at that time,
/// also if the delay is not a whole number of blocks. The chain remembers enough blocks for the
/// longest delay.
///
/// A block can be used if its status says so, its numbers are finite, its stamp follows the one
/// before by exactly one block, and all blocks in the demodulator's memory (twice the group delay)
/// are of this kind.
class BlockChain {
 public:
  struct Block {
    Orbit orbit;
    Envelope drive = Envelope::Zero();  ///< total [V]
    double reference_phase = 0.0;       ///< of the NCO at its start [rad]
    double reference_frequency = 0.0;   ///< [rad/s]
    double rotation_rate = 0.0;         ///< k Om, as far as known [rad/s]
  };

  /// If the group delay is longer, no block can be used [blocks].
  static constexpr std::size_t kLongestDelay = 31;

  explicit BlockChain(std::int64_t block_duration_ns);

  /// The next block; it is remembered if its own numbers can be used. Returns kUsable if everything
  /// that its elements depend on can be used too, otherwise the reason why it cannot.
  BlockUse admit(const OrbitalElements& elements, const ControlGains& gains, double rotation_rate);

  // About the block that was admitted last, if it was usable.

  const Block& last() const { return back(0); }
  /// Whether its own numbers and those of the block directly before it can be used: only then is
  /// there a step from that block to this one.
  bool follows() const { return usable_run_ > 1; }
  const Block& before() const { return back(1); }
  double blockDuration() const { return block_duration_; }  ///< [s]

  /// From the moment at which the elements of the block before are valid to the moment of its own
  /// elements. Skip segments with a duration of zero.
  std::array<ChainSegment, 2> segments() const;

  /// The same time as one step, for a ring whose envelope decays at `decay_rate` [1/s].
  AveragedStep<double> step(double decay_rate) const;

 private:
  // Enough for the last block and for the blocks that acted the longest delay ago; a power of 2.
  static constexpr std::size_t kMemory = 64;
  static_assert(kMemory >= kLongestDelay + 2 && (kMemory & (kMemory - 1)) == 0);

  bool setDelay(double group_delay, double duration);
  /// The block that came `blocks` before the last one.
  const Block& back(std::uint64_t blocks) const {
    return blocks_[(last_stamp_.sequence - blocks) % kMemory];
  }

  std::int64_t block_duration_ns_;
  double block_duration_;
  std::array<Block, kMemory> blocks_;  // by sequence
  BlockStamp last_stamp_;
  double group_delay_ = -1.0;        // of the present run of usable blocks [s]
  std::uint64_t whole_delay_ = 0;    // whole blocks in the delay
  double rest_of_delay_ = 0.0;       // the fraction that is left [blocks]
  std::uint64_t filter_memory_ = 1;  // blocks that go into an element
  std::uint64_t usable_run_ = 0;     // usable blocks without a break, up to now
};

}  // namespace cvg
