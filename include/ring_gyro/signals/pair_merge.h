#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <utility>

#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/orbital_elements.h"
#include "ring_gyro/signals/time_guard.h"

namespace cvg {

/// Pairs elements and gains of the same block. All input of the identifier, online and offline,
/// goes through this class.
///
/// Each topic is in order. So when the oldest waiting elements and the oldest waiting gains are of
/// different blocks, the partner of the older one can never arrive, and the older one is dropped
/// and counted. Which one is older follows from the data, never from a timeout. Within a session it
/// is the one after fewer steps back of its topic, then the one with the smaller sequence. Of two
/// sessions it is the one that both topics leave for the other. Duplicates, zero stamps, and blocks
/// of an earlier session that arrive after a new one has begun are dropped and counted.
///
/// When one topic stops, the other does not wait for ever: if more than kMostWaiting blocks wait,
/// the partner of the oldest is considered lost, and this is counted.
class PairMerge {
 public:
  /// Blocks of one topic that may wait for the other: two minutes of 1 ms blocks. This is more than
  /// the sockets between two nodes can hold, so no loss depends on which socket is read first.
  static constexpr std::size_t kMostWaiting = 1 << 17;

  struct Counts {
    std::uint64_t pairs = 0;
    std::uint64_t elements_alone = 0;  ///< elements whose gains were lost
    std::uint64_t gains_alone = 0;     ///< gains whose elements were lost
    std::uint64_t overdue = 0;         ///< of both: partner missing kMostWaiting blocks later
  };
  using Sink = std::function<void(const OrbitalElements&, const ControlGains&)>;

  /// `sink` gets the pairs in order; it may call flush(), but must not add.
  explicit PairMerge(Sink sink) : sink_(std::move(sink)) {}

  void add(const OrbitalElements& elements);
  void add(const ControlGains& gains);

  /// The input has ended: every waiting signal has no partner. New pairs may follow, as after a new
  /// start.
  void flush();

  const Counts& counts() const { return counts_; }
  std::size_t waiting() const { return elements_.waiting.size() + gains_.waiting.size(); }
  const TimeGuard::Counts& elementsCounts() const { return elements_.guard.counts(); }
  const TimeGuard::Counts& gainsCounts() const { return gains_.guard.counts(); }

 private:
  template <typename Signal>
  struct Waiting {
    Signal signal;
    std::uint64_t steps_back;  // of the topic in this session, before this signal
    std::uint64_t sessions;    // of the topic, before this signal
  };
  template <typename Signal>
  struct Topic {
    TimeGuard guard;
    std::uint64_t steps_back = 0;
    std::deque<Waiting<Signal>> waiting;
  };

  template <typename Signal>
  bool usable(Topic<Signal>& topic, const Signal& signal);
  template <typename Signal>
  static bool reached(const std::deque<Waiting<Signal>>& waiting, std::uint32_t session);
  template <typename Signal>
  void wait(Topic<Signal>& topic, const Signal& signal, std::uint64_t& alone);
  enum class Older { kElements, kGains, kNotYetKnown };
  Older older() const;
  void merge();
  void emit();

  Sink sink_;
  Topic<OrbitalElements> elements_;
  Topic<ControlGains> gains_;
  Counts counts_;
};

}  // namespace cvg
