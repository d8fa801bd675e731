#include "ring_gyro/signals/time_guard.h"

namespace cvg {

StampOrder TimeGuard::order(const BlockStamp& stamp) const {
  if (stamp.end_ns <= 0) return StampOrder::kZero;
  if (!started_) return StampOrder::kFirst;
  if (stamp.session != last_.session) {
    // A bag that loops begins the session again; if the session continues, a second plant sends it.
    const bool goes_on = left_any_ && stamp.session == left_.session &&
                         stamp.sequence >= left_.sequence && stamp.end_ns >= left_.end_ns;
    return goes_on ? StampOrder::kLeftSession : StampOrder::kNewSession;
  }
  if (stamp.sequence == last_.sequence && stamp.end_ns == last_.end_ns) {
    return StampOrder::kDuplicate;
  }
  if (stamp.sequence <= last_.sequence || stamp.end_ns <= last_.end_ns) {
    return StampOrder::kStepBack;
  }
  return stamp.sequence == last_.sequence + 1 ? StampOrder::kNext : StampOrder::kGap;
}

StampOrder TimeGuard::check(const BlockStamp& stamp) {
  const StampOrder result = order(stamp);
  switch (result) {
    case StampOrder::kFirst:
    case StampOrder::kNext:
      break;
    case StampOrder::kGap:
      counts_.lost += stamp.sequence - last_.sequence - 1;
      break;
    case StampOrder::kDuplicate:
      ++counts_.duplicates;
      break;
    case StampOrder::kStepBack:
      ++counts_.steps_back;
      break;
    case StampOrder::kNewSession:
      ++counts_.new_sessions;
      left_any_ = true;
      left_ = last_;
      break;
    case StampOrder::kLeftSession:
      ++counts_.left_sessions;
      break;
    case StampOrder::kZero:
      ++counts_.zero_stamps;
      break;
  }
  if (isUsable(result)) {
    ++counts_.accepted;
    started_ = true;
    last_ = stamp;
  }
  return result;
}

}  // namespace cvg
