#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <tuple>
#include <vector>

namespace ring_gyro::bridge {

/// Sorts messages of several topics by session and stamp; messages with the same stamp are in the
/// order of their topics. Each topic must already be in order.
///
/// A message is written when no topic can still send an earlier one. For each topic this is so when
/// it has sent a message that is as late, or, if it sends once per period, its message of the
/// previous period, or when nobody publishes it. So the result depends only on the messages, not on
/// when they arrive. Exception: a topic is later than the limits allow; then the earliest messages
/// are written without it, and its late messages are counted.
class StampMerge {
 public:
  struct Topic {
    bool waited_for = true;           ///< false: last of its stamp, and no message waits for it
    std::int64_t pause_ns = 0;        ///< after each message, with no other message of this topic
    std::function<bool()> published;  ///< whether it has a publisher; called only when it is late
  };
  /// Limits of the waiting messages.
  struct Limits {
    std::size_t bytes = 0;
    std::int64_t span_ns = std::numeric_limits<std::int64_t>::max();  ///< of stamps
  };
  using Write = std::function<void()>;

  explicit StampMerge(const Limits& limits) : limits_(limits) {}

  /// Gives the number of the topic: 0, 1, 2, ...
  std::size_t addTopic(Topic topic);
  /// `bytes`: memory that `write` holds; `write` is called once, now or later. Throws what it
  /// throws.
  void add(std::size_t topic, std::uint32_t session, std::int64_t stamp_ns, std::size_t bytes,
           Write write);
  /// Writes all waiting messages.
  void flush();

  /// Number of messages that arrived after a later one had been written.
  std::uint64_t late() const { return late_; }

 private:
  struct Place {
    std::size_t session = 0;  // number of sessions before it
    std::int64_t stamp_ns = 0;
    bool at_the_end = false;  // last of its stamp
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
    Place complete;  // no more messages up to here will arrive
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
  Place last_;  // of the last written message
  std::uint64_t late_ = 0;
};

}  // namespace ring_gyro::bridge
