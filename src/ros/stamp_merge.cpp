#include "ring_gyro/ros/stamp_merge.h"

#include <algorithm>
#include <utility>

namespace ring_gyro::bridge {

std::size_t StampMerge::addTopic(Topic topic) {
  queues_.emplace_back();
  queues_.back().topic = std::move(topic);
  return queues_.size() - 1;
}

void StampMerge::add(std::size_t topic, std::uint32_t session, std::int64_t stamp_ns,
                     std::size_t bytes, Write write) {
  auto found = std::find(sessions_.rbegin(), sessions_.rend(), session);
  if (found == sessions_.rend()) {
    sessions_.push_back(session);
    found = sessions_.rbegin();
  }
  Queue& queue = queues_[topic];
  const Place place{static_cast<std::size_t>(sessions_.rend() - found), stamp_ns,
                    !queue.topic.waited_for};
  queue.any = true;
  queue.complete = {place.session, stamp_ns + queue.topic.pause_ns, false};
  queue.waiting.push_back({place, bytes, std::move(write)});
  bytes_ += bytes;
  newest_ = std::max(newest_, place);
  for (Queue* next = first(); next != nullptr && (mayGoOn(*next) || tooMuch(*next));
       next = first()) {
    goOn(*next);
  }
}

void StampMerge::flush() {
  for (Queue* next = first(); next != nullptr; next = first()) goOn(*next);
}

/// The queue with the earliest waiting message; nullptr if no message waits.
StampMerge::Queue* StampMerge::first() {
  Queue* found = nullptr;
  for (Queue& queue : queues_) {
    if (queue.waiting.empty()) continue;
    if (found == nullptr || queue.waiting.front().place < found->waiting.front().place) {
      found = &queue;
    }
  }
  return found;
}

/// Whether no other topic can still send a message before the front of this queue.
bool StampMerge::mayGoOn(const Queue& queue) const {
  const Place& place = queue.waiting.front().place;
  return std::all_of(queues_.begin(), queues_.end(), [&place](const Queue& other) {
    return !other.waiting.empty() || !other.topic.waited_for ||
           (other.any && !(other.complete < place)) || !other.topic.published();
  });
}

bool StampMerge::tooMuch(const Queue& first) const {
  const Place& place = first.waiting.front().place;
  return bytes_ > limits_.bytes ||
         (place.session == newest_.session && newest_.stamp_ns - place.stamp_ns > limits_.span_ns);
}

void StampMerge::goOn(Queue& queue) {
  const Waiting next = std::move(queue.waiting.front());
  queue.waiting.pop_front();
  bytes_ -= next.bytes;
  if (next.place < last_) ++late_;
  last_ = std::max(last_, next.place);
  next.write();
}

}  // namespace ring_gyro::bridge
