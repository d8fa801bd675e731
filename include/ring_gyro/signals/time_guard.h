#pragma once

#include <cstdint>

#include "ring_gyro/signals/block_stamp.h"

namespace cvg {

/// Relation of a stamp to the previous one on the same topic.
enum class StampOrder {
  kFirst,
  kNext,         ///< the block after the last
  kGap,          ///< later than that: blocks are missing
  kDuplicate,    ///< the last block again
  kStepBack,     ///< an earlier block, or a later one with an earlier time: a bag that loops
  kNewSession,   ///< the plant has been started again
  kLeftSession,  ///< the session before this one continues: a second plant is still running
  kZero,         ///< no time: the stamp cannot be used
};

/// Classifies the stamps of one topic and counts those that are not next.
class TimeGuard {
 public:
  struct Counts {
    std::uint64_t accepted = 0;
    std::uint64_t lost = 0;  ///< blocks in gaps
    std::uint64_t duplicates = 0;
    std::uint64_t steps_back = 0;
    std::uint64_t new_sessions = 0;
    std::uint64_t left_sessions = 0;  ///< blocks of the session before the present one
    std::uint64_t zero_stamps = 0;
  };

  /// A stamp that is not usable is not remembered: the next one is compared with the last usable
  /// stamp.
  StampOrder check(const BlockStamp& stamp);
  /// The result that check() would give, without counting or remembering.
  StampOrder order(const BlockStamp& stamp) const;

  const Counts& counts() const { return counts_; }

 private:
  bool started_ = false;
  BlockStamp last_;
  bool left_any_ = false;
  BlockStamp left_;  // last of the previous session
  Counts counts_;
};

/// Whether a block with this order may be used.
constexpr bool isUsable(StampOrder order) {
  return order != StampOrder::kDuplicate && order != StampOrder::kZero &&
         order != StampOrder::kLeftSession;
}

}  // namespace cvg
