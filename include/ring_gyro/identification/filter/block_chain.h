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
  double middle = 0.0;    ///< 0 to 1 of the way between the moments
  EnvelopeInput input;
};

/// Pairs measured elements with the inputs that acted between them: elements are valid a group
/// delay before their block's end, inputs come from the blocks they acted in, also where the delay
/// is not a whole number of blocks. For that it remembers the blocks of the longest delay.
///
/// A block can be used when its status says so, its numbers are finite, its stamp follows the one
/// before by exactly one block, and all of the demodulator's memory (twice the group delay) holds
/// such blocks.
class BlockChain {
 public:
  struct Block {
    Orbit orbit;
    Envelope drive = Envelope::Zero();  ///< total [V]
    double reference_phase = 0.0;       ///< of the NCO at its start [rad]
    double reference_frequency = 0.0;   ///< [rad/s]
    double rotation_rate = 0.0;         ///< k Om, as far as known [rad/s]
  };

  /// With a longer group delay no block can be used [blocks].
  static constexpr std::size_t kLongestDelay = 31;

  explicit BlockChain(std::int64_t block_duration_ns);

  /// The next block, remembered when its own numbers can be used. kUsable when everything that its
  /// elements depend on can be used too, else the reason why it cannot.
  BlockUse admit(const OrbitalElements& elements, const ControlGains& gains, double rotation_rate);

  // Of the block that was admitted last, if it was usable.

  const Block& last() const { return back(0); }
  /// Whether its own numbers and those of the block directly before it can be used: only then is
  /// there a way from that one.
  bool follows() const { return usable_run_ > 1; }
  const Block& before() const { return back(1); }
  double blockDuration() const { return block_duration_; }  ///< [s]

  /// From where the elements of the block before are valid to where its own are. Segments of no
  /// duration are to be skipped.
  std::array<ChainSegment, 2> segments() const;

  /// The same way as one step, for a ring whose envelope decays at `decay_rate` [1/s].
  AveragedStep<double> step(double decay_rate) const;

 private:
  // The last block, and before it what acted the longest delay ago; a power of 2.
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
  std::uint64_t whole_delay_ = 0;    // blocks in it
  double rest_of_delay_ = 0.0;       // what is left of it [blocks]
  std::uint64_t filter_memory_ = 1;  // blocks that go into an element
  std::uint64_t usable_run_ = 0;     // usable blocks without a break up to now
};

}  // namespace cvg
