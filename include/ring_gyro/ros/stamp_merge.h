#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <tuple>
#include <vector>

namespace ring_gyro::bridge {

/// Puts messages that arrive topic by topic into the order of session and stamp, those of one stamp
/// in the order of their topics. Each topic by itself is in order.
///
/// A message goes on when no topic can still send an earlier one: each has sent one as late, or a
/// topic that sends once a period has sent that of the period before, or nobody publishes it. The
/// result depends on the messages alone, not on when they arrive, unless a topic is late by more
/// than what may wait: then the earliest go on without it, and what it sends later than that is
/// counted.
class StampMerge {
 public:
  struct Topic {
    bool waited_for = true;           ///< otherwise last of its stamp, and it delays nobody
    std::int64_t pause_ns = 0;        ///< after each message, in which no other has its stamp
    std::function<bool()> published;  ///< whether anybody sends; asked only when it is late
  };
  /// What may wait at most.
  struct Limits {
    std::size_t bytes = 0;
    std::int64_t span_ns = std::numeric_limits<std::int64_t>::max();  ///< of stamps
  };
  using Write = std::function<void()>;

  explicit StampMerge(const Limits& limits) : limits_(limits) {}

  /// Gives its number: 0, 1, 2, ...
  std::size_t addTopic(Topic topic);
  /// `bytes`: what `write` keeps; `write` is called once, now or later. Throws what it throws.
  void add(std::size_t topic, std::uint32_t session, std::int64_t stamp_ns, std::size_t bytes,
           Write write);
  /// All that waits goes on.
  void flush();

  /// Messages that came after a later one had gone on.
  std::uint64_t late() const { return late_; }

 private:
  struct Place {
    std::size_t session = 0;  // how many came before
    std::int64_t stamp_ns = 0;
    bool at_the_end = false;  // of its stamp
    bool operator<(const Place& other) const {
      return std::tie(session, stamp_ns, at_the_end) <
             std::tie(other.session, other.stamp_ns, other.at_the_end);
    }
  };
  struct Waiting {
    Place place;
    std::size_t bytes;
    Write write;
  };
  struct Queue {
    Topic topic;
    bool any = false;
    Place complete;  // nothing up to here is still to come
    std::deque<Waiting> waiting;
  };

  Queue* first();
  bool mayGoOn(const Queue& queue) const;
  bool tooMuch(const Queue& first) const;
  void goOn(Queue& queue);

  Limits limits_;
  std::vector<Queue> queues_;
  std::vector<std::uint32_t> sessions_;
  std::size_t bytes_ = 0;
  Place newest_;
  Place last_;  // that has gone on
  std::uint64_t late_ = 0;
};

}  // namespace ring_gyro::bridge
