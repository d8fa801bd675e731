#pragma once

#include <ros/time.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <queue>
#include <string>
#include <utility>
#include <vector>

#include "ring_gyro/ros/bag_contents.h"
#include "ring_gyro/ros/bag_records.h"

namespace ring_gyro::bridge {

/// A serialised message of a bag; valid until the sink returns.
struct BagMessage {
  std::uint32_t connection = 0;
  ros::Time time;                 ///< of the bag
  std::uint8_t* bytes = nullptr;  ///< not const, because roscpp's deserialiser requires it
  std::uint32_t size = 0;
};

/// For each connection the function that gets its messages.
using BagSinks = std::map<std::uint32_t, std::function<void(const BagMessage&)>>;

/// Reads messages of a bag in the order of bag time, whatever their order in the file.
///
/// A chunk is opened when the time reaches its first message, and its messages are held until their
/// time comes. So each chunk is decompressed once, and memory holds the messages of the chunks that
/// overlap at one time (rosbag::View decompresses a chunk whenever two consecutive messages are in
/// different chunks). When so many chunks overlap that more than `most_held` bytes would be held,
/// the later half of the messages is dropped, and its chunks are opened again when its time comes:
/// a bag in random order is read in about 2 size / most_held passes.
///
/// Messages with equal times come in the same order as from rosbag::View (for up to 16 connections;
/// for more connections View's order is that of an unstable sort).
class ChunkMerge {
 public:
  static constexpr std::size_t kMostHeld = 128u << 20;

  struct Outcome {
    std::uint64_t chunks_opened = 0;  ///< decompressions
    BagLoss loss;                     ///< unreadable chunks, which are skipped
  };

  /// For messages with bag time in [from, to]. Throws std::runtime_error when the file cannot be
  /// opened.
  ChunkMerge(const std::string& path, const BagContents& contents, const BagSinks& sinks,
             const ros::Time& from, const ros::Time& to, std::size_t most_held = kMostHeld);

  /// To be called once. Throws what the sinks throw.
  Outcome run();

 private:
  struct Entry {
    ros::Time time;
    std::uint32_t size = 0;
    std::size_t offset = 0;
  };
  /// Messages of one connection from one chunk, in order.
  struct Run {
    std::size_t chunk = 0;
    std::size_t next = 0;
    std::vector<Entry> entries;
    std::vector<std::uint8_t> bytes;

    const ros::Time& time() const { return entries[next].time; }
    std::size_t heldBytes() const { return bytes.size() + entries.size() * sizeof(Entry); }
    void clear() {
      next = 0;
      entries.clear();
      bytes.clear();
    }
  };
  struct Topic {
    std::uint32_t connection = 0;
    const std::function<void(const BagMessage&)>* sink = nullptr;
    std::int64_t last_delivered = 0;         // its number among all messages delivered
    std::vector<std::unique_ptr<Run>> runs;  // a heap with the next message at the front
    std::unique_ptr<Run> fresh;              // of the chunk that is being opened
  };
  /// The time at which a chunk must be opened.
  struct Opening {
    ros::Time time;
    std::size_t chunk;
    bool operator>(const Opening& other) const {
      return time != other.time ? time > other.time : chunk > other.chunk;
    }
  };
  struct Pending {
    bool open = false;  // still to be opened, at `time`
    ros::Time time;
    bool again = false;  // opened before: messages up to delivered_ have been delivered
  };

  static bool later(const std::unique_ptr<Run>& a, const std::unique_ptr<Run>& b);
  Topic* find(std::uint32_t connection);
  Topic* next() const;
  void deliver(Topic& topic);
  void openNext();
  void open(std::size_t chunk, bool again);
  std::uint64_t endOf(std::size_t chunk) const;
  void hold(const ChunkMessage& message, Topic& topic);
  void insert(Topic& topic, std::size_t chunk);
  void postpone(std::size_t chunk, const ros::Time& time);
  void dropLaterHalf();
  void dropAfterHorizon(Run& run);

  BagRecordFile file_;
  const BagContents& contents_;
  ros::Time from_;
  ros::Time to_;
  std::size_t most_held_;
  std::vector<Topic> topics_;     // by connection
  std::vector<Topic*> active_;    // those with messages
  std::vector<Pending> pending_;  // by chunk
  std::priority_queue<Opening, std::vector<Opening>, std::greater<Opening>> openings_;
  ros::Time horizon_;    // messages are held up to here
  ros::Time delivered_;  // after a horizon: all messages up to here have been delivered
  std::size_t held_ = 0;
  std::int64_t deliveries_ = 0;
  std::vector<std::unique_ptr<Run>> spare_;
  std::string header_;
  std::string packed_;
  std::string chunk_;
  Outcome outcome_;
};

}  // namespace ring_gyro::bridge
