#include "ring_gyro/identification/filter/period_keeper.h"

namespace cvg {

PeriodKeeper::Follows PeriodKeeper::followWithBreak(const BlockStamp& stamp) {
  complete_ = false;
  if (started_ && stamp.session == last_.session && stamp.sequence > last_.sequence) {
    lost_ += stamp.sequence - last_.sequence - 1;
    if (stamp.sequence / period_blocks_ != last_.sequence / period_blocks_ && !atLastBlock()) {
      rejected_ += blocks_in_period_;  // blocks of a period whose end was lost
      blocks_in_period_ = 0;
    }
    block_of_period_ = stamp.sequence % period_blocks_;
    return Follows::kAfterGap;
  }
  if (started_) ++restarts_;
  started_ = true;
  first_sequence_ = stamp.sequence;
  used_ = rejected_ = lost_ = 0;
  blocks_in_period_ = 0;
  lowest_ = highest_ = 0.0;
  block_of_period_ = stamp.sequence % period_blocks_;
  return Follows::kNothing;
}

void PeriodKeeper::finish(bool used) {
  if (used) {
    const bool first = used_ == 0;
    lowest_ = first ? lowest_in_period_ : std::min(lowest_, lowest_in_period_);
    highest_ = first ? highest_in_period_ : std::max(highest_, highest_in_period_);
  }
  (used ? used_ : rejected_) += blocks_in_period_;
  blocks_in_period_ = 0;
  complete_ = false;
}

}  // namespace cvg
