#include "ring_gyro/signals/pair_merge.h"

#include <algorithm>

namespace cvg {
namespace {

bool sameBlock(const BlockStamp& a, const BlockStamp& b) {
  return a.session == b.session && a.sequence == b.sequence && a.end_ns == b.end_ns;
}

}  // namespace

/// Whether any waiting signal is of this session.
template <typename Signal>
bool PairMerge::reached(const std::deque<Waiting<Signal>>& waiting, std::uint32_t session) {
  // All are of one session: no need to check each.
  if (waiting.front().sessions == waiting.back().sessions) {
    return waiting.front().signal.stamp.session == session;
  }
  return std::any_of(waiting.begin(), waiting.end(), [session](const auto& entry) {
    return entry.signal.stamp.session == session;
  });
}

template <typename Signal>
void PairMerge::wait(Topic<Signal>& topic, const Signal& signal, std::uint64_t& alone) {
  topic.waiting.push_back({signal, topic.steps_back, topic.guard.counts().new_sessions});
  if (topic.waiting.size() <= kMostWaiting) return;
  topic.waiting.pop_front();
  ++alone;
  ++counts_.overdue;
}

template <typename Signal>
bool PairMerge::usable(Topic<Signal>& topic, const Signal& signal) {
  const StampOrder order = topic.guard.check(signal.stamp);
  if (!isUsable(order)) return false;
  if (order == StampOrder::kNewSession) topic.steps_back = 0;
  if (order == StampOrder::kStepBack) ++topic.steps_back;
  return true;
}

void PairMerge::add(const OrbitalElements& elements) {
  if (!usable(elements_, elements)) return;
  if (elements_.waiting.empty() && !gains_.waiting.empty() &&
      sameBlock(elements.stamp, gains_.waiting.front().signal.stamp)) {
    const ControlGains gains = gains_.waiting.front().signal;
    gains_.waiting.pop_front();
    ++counts_.pairs;
    sink_(elements, gains);
    return;
  }
  wait(elements_, elements, counts_.elements_alone);
  merge();
}

/// Usually the partner already waits; then nothing has to be queued.
void PairMerge::add(const ControlGains& gains) {
  if (!usable(gains_, gains)) return;
  if (gains_.waiting.empty() && !elements_.waiting.empty() &&
      sameBlock(elements_.waiting.front().signal.stamp, gains.stamp)) {
    const OrbitalElements elements = elements_.waiting.front().signal;
    elements_.waiting.pop_front();
    ++counts_.pairs;
    sink_(elements, gains);
    return;
  }
  wait(gains_, gains, counts_.gains_alone);
  merge();
}

void PairMerge::emit() {
  const Waiting<OrbitalElements> elements = elements_.waiting.front();
  const Waiting<ControlGains> gains = gains_.waiting.front();
  elements_.waiting.pop_front();
  gains_.waiting.pop_front();
  ++counts_.pairs;
  sink_(elements.signal, gains.signal);
}

PairMerge::Older PairMerge::older() const {
  const auto& elements = elements_.waiting.front();
  const auto& gains = gains_.waiting.front();
  const BlockStamp& elements_stamp = elements.signal.stamp;
  const BlockStamp& gains_stamp = gains.signal.stamp;
  bool elements_are_older = false;
  if (elements_stamp.session == gains_stamp.session) {
    elements_are_older = elements.steps_back != gains.steps_back
                             ? elements.steps_back < gains.steps_back
                             : elements_stamp.sequence < gains_stamp.sequence;
  } else {
    const bool elements_left_behind = reached(elements_.waiting, gains_stamp.session);
    const bool gains_left_behind = reached(gains_.waiting, elements_stamp.session);
    if (!elements_left_behind && !gains_left_behind) return Older::kNotYetKnown;
    elements_are_older = elements_left_behind != gains_left_behind
                             ? elements_left_behind
                             : elements_stamp.end_ns < gains_stamp.end_ns;
  }
  return elements_are_older ? Older::kElements : Older::kGains;
}

void PairMerge::merge() {
  while (!elements_.waiting.empty() && !gains_.waiting.empty()) {
    if (sameBlock(elements_.waiting.front().signal.stamp, gains_.waiting.front().signal.stamp)) {
      emit();
      continue;
    }
    switch (older()) {
      case Older::kElements:
        ++counts_.elements_alone;
        elements_.waiting.pop_front();
        break;
      case Older::kGains:
        ++counts_.gains_alone;
        gains_.waiting.pop_front();
        break;
      case Older::kNotYetKnown:
        return;
    }
  }
}

void PairMerge::flush() {
  counts_.elements_alone += elements_.waiting.size();
  counts_.gains_alone += gains_.waiting.size();
  elements_.waiting.clear();
  gains_.waiting.clear();
}

}  // namespace cvg
