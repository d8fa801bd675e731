#pragma once

#include <ros/time.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace ring_gyro::bridge {

/// One topic as one publisher gave it.
struct BagConnection {
  std::uint32_t id = 0;
  std::string topic;
  std::string type;
  std::string md5;
  std::uint64_t messages = 0;
};

/// What a chunk holds of one connection; times are bag time.
struct ChunkShare {
  std::uint32_t connection = 0;
  std::uint64_t messages = 0;
  ros::Time begin = ros::TIME_MAX;  ///< of the earliest
  ros::Time end = ros::TIME_MIN;    ///< and of the latest message

  void add(const ros::Time& time);
};

struct BagChunk {
  std::uint64_t position = 0;  ///< of its record in the file
  std::vector<ChunkShare> shares;

  ChunkShare& shareOf(std::uint32_t connection);
};

/// What a bag (format 2.0) holds and where, without the messages: some 30 bytes a chunk and topic.
struct BagContents {
  std::vector<BagConnection> connections;  ///< those with messages, by id
  std::vector<BagChunk> chunks;            ///< in the order of the index, or else of the file
  std::uint64_t end_of_chunks = 0;         ///< in the file
  ros::Time begin = ros::TIME_MAX;         ///< bag time of the earliest
  ros::Time end = ros::TIME_MIN;           ///< and of the latest message

  std::uint64_t messages() const;
};

/// From the index. Throws std::runtime_error when there is none, or it does not fit the file.
/// `on_entry`: gets connection and bag time of each message, chunk by chunk.
BagContents contentsByIndex(
    const std::string& path,
    const std::function<void(std::uint32_t, const ros::Time&)>& on_entry = {});

/// What could not be read.
struct BagLoss {
  std::uint64_t bytes = 0;
  std::uint64_t first = 0;  ///< where in the file the first of them is

  void add(std::uint64_t where, std::uint64_t count);
};

struct BagScan {
  BagContents contents;
  BagLoss loss;
};

/// From the records, front to back: a bag without an index, as a recorder leaves it that was
/// killed, or one that was cut off. What cannot be read is passed over and counted. Holds one chunk
/// in memory. Throws std::runtime_error when the file cannot be read at all.
BagScan contentsByScan(const std::string& path);

/// Name of the plugin that encrypted a bag; empty: not encrypted, or no bag of format 2.0.
std::string bagEncryptor(const std::string& path);

}  // namespace ring_gyro::bridge
