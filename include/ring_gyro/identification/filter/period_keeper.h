#pragma once

#include <algorithm>
#include <cstdint>

#include "ring_gyro/signals/block_stamp.h"

namespace cvg {

/// Divides the blocks of a session into periods and counts what becomes of them. A period ends
/// where (sequence + 1) is a multiple of the period, whenever the identifier was started. It is
/// used whole or not at all.
class PeriodKeeper {
 public:
  /// How a block follows the one before.
  enum class Follows : std::uint8_t {
    kDirectly,
    /// Blocks are missing between the two: the block's period is not complete, unless the block is
    /// the first of its period.
    kAfterGap,
    /// It is the first block, or of a new session, or not later: everything starts again.
    kNothing,
  };

  explicit PeriodKeeper(std::int64_t period_blocks)
      : period_blocks_(static_cast<std::uint64_t>(period_blocks)) {}

  /// The next block.
  Follows follow(const BlockStamp& stamp) {
    Follows how = Follows::kDirectly;
    if (started_ && stamp.session == last_.session && stamp.sequence == last_.sequence + 1) {
      if (++block_of_period_ == period_blocks_) block_of_period_ = 0;
    } else {
      how = followWithBreak(stamp);
    }
    last_ = stamp;
    if (atFirstBlock()) {
      blocks_in_period_ = 0;
      complete_ = true;
    }
    ++blocks_in_period_;
    return how;
  }
  std::uint64_t blockOfPeriod() const { return block_of_period_; }  ///< of the last block, from 0
  bool atFirstBlock() const { return block_of_period_ == 0; }       ///< of a period
  bool atLastBlock() const { return block_of_period_ + 1 == period_blocks_; }  ///< of a period

  /// The last block can be used; `theta` is its pattern angle [rad].
  void see(double theta) {
    if (atFirstBlock()) lowest_in_period_ = highest_in_period_ = theta;
    lowest_in_period_ = std::min(lowest_in_period_, theta);
    highest_in_period_ = std::max(highest_in_period_, theta);
  }
  /// The present period holds something that cannot be used.
  void spoil() { complete_ = false; }
  /// Whether the present period has had nothing but usable blocks from its first one on.
  bool complete() const { return complete_; }
  /// The present period has ended; `used`: its data have entered the estimate.
  void finish(bool used);

  const BlockStamp& last() const { return last_; }
  std::int64_t periodBlocks() const { return static_cast<std::int64_t>(period_blocks_); }
  // Counts since the start of the session; used, rejected and lost blocks together are all blocks
  // from the first to the last.
  std::uint64_t firstSequence() const { return first_sequence_; }
  std::uint64_t used() const { return used_; }
  std::uint64_t rejected() const { return rejected_; }
  std::uint64_t lost() const { return lost_; }
  double angleCovered() const { return highest_ - lowest_; }  ///< span of theta used [rad]
  /// How often everything started again, the first start not counted.
  std::uint64_t restarts() const { return restarts_; }

 private:
  Follows followWithBreak(const BlockStamp& stamp);

  std::uint64_t period_blocks_;
  bool started_ = false;
  BlockStamp last_;
  std::uint64_t block_of_period_ = 0;  // of the last block
  bool complete_ = false;
  std::uint64_t blocks_in_period_ = 0;
  double lowest_in_period_ = 0.0;
  double highest_in_period_ = 0.0;

  std::uint64_t first_sequence_ = 0;
  std::uint64_t used_ = 0;
  std::uint64_t rejected_ = 0;
  std::uint64_t lost_ = 0;
  std::uint64_t restarts_ = 0;
  double lowest_ = 0.0;
  double highest_ = 0.0;
};

}  // namespace cvg
