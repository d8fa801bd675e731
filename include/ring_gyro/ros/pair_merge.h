#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <utility>

#include "ring_gyro/control/control_gains.h"
#include "ring_gyro/ros/time_guard.h"

namespace ring_gyro {

/// Brings elements and gains of the same block together: the one way into the identifier, online
/// and offline.
///
/// Each topic is in order, so when the oldest waiting elements and the oldest waiting gains are of
/// different blocks, the partner of the older one can never come: it is dropped and counted. What
/// is older follows from the data alone, never from a timeout. Within a session: fewer steps back
/// of its topic, then the smaller sequence. Of two sessions: the one that its topic too leaves for
/// the other's. Duplicates and zero stamps are left out and counted.
class PairMerge {
 public:
  struct Counts {
    std::uint64_t pairs = 0;
    std::uint64_t elements_alone = 0;  ///< elements whose gains were lost
    std::uint64_t gains_alone = 0;     ///< gains whose elements were lost
  };
  using Sink = std::function<void(const OrbitalElements&, const ControlGains&)>;

  /// `sink` gets the pairs in order; it may flush, but not add.
  explicit PairMerge(Sink sink) : sink_(std::move(sink)) {}

  void add(const OrbitalElements& elements);
  void add(const ControlGains& gains);

  /// The input has ended: what still waits is alone. Pairs may follow, as of a new start.
  void flush();

  const Counts& counts() const { return counts_; }
  const TimeGuard::Counts& elementsCounts() const { return elements_.guard.counts(); }
  const TimeGuard::Counts& gainsCounts() const { return gains_.guard.counts(); }

 private:
  template <typename Signal>
  struct Waiting {
    Signal signal;
    std::uint64_t steps_back;  // of the topic in this session, before this signal
  };
  template <typename Signal>
  struct Topic {
    TimeGuard guard;
    std::uint64_t steps_back = 0;
    std::deque<Waiting<Signal>> waiting;
  };

  template <typename Signal>
  bool usable(Topic<Signal>& topic, const Signal& signal);
  enum class Older { kElements, kGains, kNotYetKnown };
  Older older() const;
  void merge();
  void emit();

  Sink sink_;
  Topic<OrbitalElements> elements_;
  Topic<ControlGains> gains_;
  Counts counts_;
};

}  // namespace ring_gyro
