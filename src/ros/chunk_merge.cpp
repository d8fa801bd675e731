#include "ring_gyro/ros/chunk_merge.h"

#include <algorithm>
#include <string_view>

namespace ring_gyro::bridge {

ChunkMerge::ChunkMerge(const std::string& path, const BagContents& contents, const BagSinks& sinks,
                       const ros::Time& from, const ros::Time& to, std::size_t most_held)
    : file_(path),
      contents_(contents),
      from_(from),
      to_(to),
      most_held_(most_held),
      pending_(contents.chunks.size()),
      horizon_(to) {
  for (const auto& [connection, sink] : sinks) {
    topics_.emplace_back();
    topics_.back().connection = connection;
    topics_.back().sink = &sink;
    // Before the first message a View has the connections in order, with the last one at the front.
    topics_.back().last_delivered = deliveries_++;
  }
  for (std::size_t chunk = 0; chunk < contents.chunks.size(); ++chunk) {
    bool wanted = false;
    ros::Time first = ros::TIME_MAX;
    for (const ChunkShare& share : contents.chunks[chunk].shares) {
      if (sinks.count(share.connection) == 0 || share.begin > to || share.end < from) continue;
      first = std::min(first, std::max(share.begin, from));
      wanted = true;
    }
    if (wanted) postpone(chunk, first);
  }
}

ChunkMerge::Outcome ChunkMerge::run() {
  while (true) {
    Topic* const topic = next();
    if (!openings_.empty() &&
        (topic == nullptr || openings_.top().time <= topic->runs.front()->time())) {
      openNext();
    } else if (topic != nullptr) {
      deliver(*topic);
    } else {
      return outcome_;
    }
  }
}

/// Whether a comes after b within their connection.
bool ChunkMerge::later(const std::unique_ptr<Run>& a, const std::unique_ptr<Run>& b) {
  return a->time() != b->time() ? a->time() > b->time() : a->chunk > b->chunk;
}

ChunkMerge::Topic* ChunkMerge::find(std::uint32_t connection) {
  const auto found = std::lower_bound(
      topics_.begin(), topics_.end(), connection,
      [](const Topic& topic, std::uint32_t wanted) { return topic.connection < wanted; });
  return found != topics_.end() && found->connection == connection ? &*found : nullptr;
}

/// The topic with the next message; nullptr if none is held. For equal times View takes the
/// connection that was served last.
ChunkMerge::Topic* ChunkMerge::next() const {
  Topic* found = nullptr;
  for (Topic* const topic : active_) {
    if (found != nullptr) {
      const ros::Time& time = topic->runs.front()->time();
      const ros::Time& other = found->runs.front()->time();
      if (time > other || (time == other && topic->last_delivered < found->last_delivered))
        continue;
    }
    found = topic;
  }
  return found;
}

void ChunkMerge::deliver(Topic& topic) {
  std::pop_heap(topic.runs.begin(), topic.runs.end(), later);
  Run& run = *topic.runs.back();
  const Entry& entry = run.entries[run.next++];
  topic.last_delivered = deliveries_++;
  (*topic.sink)({topic.connection, entry.time, run.bytes.data() + entry.offset, entry.size});
  if (run.next < run.entries.size()) {
    std::push_heap(topic.runs.begin(), topic.runs.end(), later);
    return;
  }
  held_ -= run.heldBytes();
  if (spare_.size() < topics_.size()) spare_.push_back(std::move(topic.runs.back()));
  topic.runs.pop_back();
  if (topic.runs.empty()) active_.erase(std::find(active_.begin(), active_.end(), &topic));
}

void ChunkMerge::openNext() {
  const Opening opening = openings_.top();
  openings_.pop();
  Pending& pending = pending_[opening.chunk];
  if (!pending.open || pending.time != opening.time) return;  // replaced by an earlier opening
  if (opening.time > horizon_) {
    delivered_ = horizon_;
    horizon_ = to_;
  }
  const bool again = pending.again;
  pending.open = false;
  pending.again = true;
  open(opening.chunk, again);
  if (held_ > most_held_) dropLaterHalf();
}

void ChunkMerge::open(std::size_t chunk, bool again) {
  const std::uint64_t position = contents_.chunks[chunk].position;
  std::uint32_t length = 0;
  ChunkState state = ChunkState::kNoHeader;
  if (file_.seek(position) && file_.takeHeader(header_, length)) {
    state = takeChunk(file_, header_, length, packed_, chunk_);
  }
  if (state != ChunkState::kWhole) {
    outcome_.loss.add(
        position, (state == ChunkState::kNoHeader ? endOf(chunk) : file_.position()) - position);
    return;
  }
  ++outcome_.chunks_opened;
  std::string_view rest = chunk_;
  BagRecord record;
  ChunkMessage message;
  while (takeRecord(rest, record)) {
    if (!asMessage(record, message) || message.time < from_ || message.time > to_ ||
        (again && message.time <= delivered_)) {
      continue;
    }
    Topic* const topic = find(message.connection);
    if (topic == nullptr) continue;
    if (message.time > horizon_) {
      postpone(chunk, message.time);
    } else {
      hold(message, *topic);
    }
  }
  if (!rest.empty() && !again) outcome_.loss.add(position, rest.size());
  for (Topic& topic : topics_) {
    if (topic.fresh) insert(topic, chunk);
  }
}

/// Position at which the next chunk begins.
std::uint64_t ChunkMerge::endOf(std::size_t chunk) const {
  const std::uint64_t position = contents_.chunks[chunk].position;
  std::uint64_t end = contents_.end_of_chunks;
  for (const BagChunk& other : contents_.chunks) {
    if (other.position > position) end = std::min(end, other.position);
  }
  return std::max(end, position);
}

void ChunkMerge::hold(const ChunkMessage& message, Topic& topic) {
  if (!topic.fresh) {
    if (spare_.empty()) {
      topic.fresh = std::make_unique<Run>();
    } else {
      topic.fresh = std::move(spare_.back());
      spare_.pop_back();
      topic.fresh->clear();
    }
  }
  Run& run = *topic.fresh;
  run.entries.push_back(
      {message.time, static_cast<std::uint32_t>(message.bytes.size()), run.bytes.size()});
  run.bytes.insert(run.bytes.end(), message.bytes.begin(), message.bytes.end());
}

/// Adds the messages taken from a chunk to the others of their connection.
void ChunkMerge::insert(Topic& topic, std::size_t chunk) {
  Run& run = *topic.fresh;
  run.chunk = chunk;
  const auto earlier = [](const Entry& a, const Entry& b) { return a.time < b.time; };
  if (!std::is_sorted(run.entries.begin(), run.entries.end(), earlier)) {
    std::stable_sort(run.entries.begin(), run.entries.end(), earlier);
  }
  held_ += run.heldBytes();
  if (topic.runs.empty()) active_.push_back(&topic);
  topic.runs.push_back(std::move(topic.fresh));
  std::push_heap(topic.runs.begin(), topic.runs.end(), later);
}

/// Schedules the chunk to be opened at `time`, unless an earlier time is already set.
void ChunkMerge::postpone(std::size_t chunk, const ros::Time& time) {
  Pending& pending = pending_[chunk];
  if (pending.open && pending.time <= time) return;
  pending.open = true;
  pending.time = time;
  openings_.push({time, chunk});
}

void ChunkMerge::dropLaterHalf() {
  std::vector<ros::Time> times;
  for (const Topic* const topic : active_) {
    for (const auto& run : topic->runs) {
      for (std::size_t i = run->next; i < run->entries.size(); ++i) {
        times.push_back(run->entries[i].time);
      }
    }
  }
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  horizon_ = *middle;
  held_ = 0;
  for (Topic* const topic : active_) {
    auto& runs = topic->runs;
    for (auto& run : runs) {
      dropAfterHorizon(*run);
      held_ += run->heldBytes();
    }
    runs.erase(std::remove_if(runs.begin(), runs.end(),
                              [](const auto& run) { return run->entries.empty(); }),
               runs.end());
    std::make_heap(runs.begin(), runs.end(), later);
  }
  active_.erase(std::remove_if(active_.begin(), active_.end(),
                               [](const Topic* topic) { return topic->runs.empty(); }),
                active_.end());
  spare_.clear();
  // All held messages have one time, so no more can be dropped.
  if (held_ > most_held_) most_held_ = 2 * held_;
}

void ChunkMerge::dropAfterHorizon(Run& run) {
  Run kept;
  kept.chunk = run.chunk;
  for (std::size_t i = run.next; i < run.entries.size(); ++i) {
    const Entry& entry = run.entries[i];
    if (entry.time > horizon_) {
      postpone(run.chunk, entry.time);
      break;
    }
    const auto bytes = run.bytes.begin() + static_cast<std::ptrdiff_t>(entry.offset);
    kept.entries.push_back({entry.time, entry.size, kept.bytes.size()});
    kept.bytes.insert(kept.bytes.end(), bytes, bytes + entry.size);
  }
  run = std::move(kept);
}

}  // namespace ring_gyro::bridge
