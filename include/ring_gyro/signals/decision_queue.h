#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace cvg {

/// Decisions on their way to the loops. Each is made from the data of one period and acts from the
/// drive of block `effective_sequence`, one period later, until the next decision acts.
///
/// In lockstep a block whose answer needs a decision that has not arrived waits for it, so that the
/// timing of threads cannot change a run. No block waits for a decision that has already been
/// applied, or whose data this node has not seen, because that decision would never arrive.
/// `Decision` has a session and an effective_sequence.
template <typename Decision>
class DecisionQueue {
 public:
  /// Decisions that wait for their block: one is due each period, one period ahead.
  static constexpr std::size_t kMostWaiting = 16;

  struct Counts {
    std::uint64_t late = 0;     ///< arrived after their block had been answered
    std::uint64_t foreign = 0;  ///< of another session: dropped
    std::uint64_t early = 0;    ///< more than kMostWaiting: those of the latest blocks dropped
  };

  /// `period_blocks`: blocks from one decision to the next.
  explicit DecisionQueue(std::uint64_t period_blocks) : period_blocks_(period_blocks) {
    waiting_.reserve(kMostWaiting + 1);
  }

  /// Takes a decision that has arrived.
  void add(Decision decision) {
    if (applied_any_ && decision.session != session_) {
      ++counts_.foreign;
      return;
    }
    if (applied_any_ && decision.effective_sequence <= applied_up_to_) ++counts_.late;
    // Sorted by block, whatever the order of arrival.
    const auto after =
        std::upper_bound(waiting_.begin(), waiting_.end(), decision.effective_sequence,
                         [](std::uint64_t block, const Decision& other) {
                           return block < other.effective_sequence;
                         });
    waiting_.insert(after, std::move(decision));
    if (waiting_.size() <= kMostWaiting) return;
    waiting_.pop_back();
    ++counts_.early;
  }

  /// Whether a decision is due with the drive of block `acts_in` and has not arrived. No decision
  /// is due in the first two periods.
  bool mustWaitFor(std::uint32_t session, std::uint64_t acts_in) const {
    if (acts_in % period_blocks_ != 0 || acts_in < 2 * period_blocks_) return false;
    if (applied_any_) {
      const bool used_up = session == session_ && acts_in <= applied_up_to_;
      const bool data_seen = session == session_ && acts_in - period_blocks_ >= first_applied_;
      if (used_up || !data_seen) return false;
    }
    return std::none_of(waiting_.begin(), waiting_.end(), [&](const Decision& decision) {
      return decision.session == session && decision.effective_sequence == acts_in;
    });
  }

  /// Calls `apply`, in order, with each decision that acts by the drive of block `acts_in` and has
  /// not been applied yet.
  template <typename Apply>
  void applyDue(std::uint32_t session, std::uint64_t acts_in, Apply apply) {
    if (!applied_any_ || session != session_) first_applied_ = acts_in;
    applied_any_ = true;
    session_ = session;
    applied_up_to_ = acts_in;
    // Such a decision is latched from an earlier run; its block may be far ahead.
    const auto foreign =
        std::remove_if(waiting_.begin(), waiting_.end(),
                       [session](const Decision& decision) { return decision.session != session; });
    counts_.foreign += static_cast<std::uint64_t>(waiting_.end() - foreign);
    waiting_.erase(foreign, waiting_.end());
    auto due = waiting_.begin();
    for (; due != waiting_.end() && due->effective_sequence <= acts_in; ++due) apply(*due);
    waiting_.erase(waiting_.begin(), due);
  }

  const Counts& counts() const { return counts_; }

 private:
  std::uint64_t period_blocks_;
  std::vector<Decision> waiting_;  // sorted by block
  bool applied_any_ = false;
  std::uint32_t session_ = 0;
  std::uint64_t first_applied_ = 0;  // block, of the session
  std::uint64_t applied_up_to_ = 0;  // block
  Counts counts_;
};

}  // namespace cvg
