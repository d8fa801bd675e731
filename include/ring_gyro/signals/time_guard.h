#pragma once

#include <cstdint>

#include "ring_gyro/signals/block_stamp.h"

namespace cvg {

/// How a stamp follows the one before it on the same topic.
enum class StampOrder {
  kFirst,
  kNext,         ///< the block after the last
  kGap,          ///< later than that: blocks are missing
  kDuplicate,    ///< the last block again
  kStepBack,     ///< an earlier block, or a later one with an earlier time: a bag that loops
  kNewSession,   ///< the plant has been started again
  kLeftSession,  ///< of the session before, going on: another plant that still runs
  kZero,         ///< no time at all: says nothing
};

/// Sorts the stamps of one topic into those that follow and those that do not, and counts.
class TimeGuard {
 public:
  struct Counts {
    std::uint64_t accepted = 0;
    std::uint64_t lost = 0;  ///< blocks in gaps
    std::uint64_t duplicates = 0;
    std::uint64_t steps_back = 0;
    std::uint64_t new_sessions = 0;
    std::uint64_t left_sessions = 0;  ///< blocks of a session that had been left
    std::uint64_t zero_stamps = 0;
  };

  /// What is not usable is not remembered: the next is compared with what came before.
  StampOrder check(const BlockStamp& stamp);
  /// What check() would say, without counting or remembering.
  StampOrder order(const BlockStamp& stamp) const;

  const Counts& counts() const { return counts_; }

 private:
  bool started_ = false;
  BlockStamp last_;
  bool left_any_ = false;
  BlockStamp left_;  // last of the session before
  Counts counts_;
};

/// Whether a block with this order is to be used at all.
constexpr bool isUsable(StampOrder order) {
  return order != StampOrder::kDuplicate && order != StampOrder::kZero &&
         order != StampOrder::kLeftSession;
}

}  // namespace cvg
