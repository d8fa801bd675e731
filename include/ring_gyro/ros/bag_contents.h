#pragma once

#include <ros/time.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace ring_gyro::bridge {

/// One topic of one publisher.
struct BagConnection {
  std::uint32_t id = 0;
  std::string topic;
  std::string type;
  std::string md5;
  std::uint64_t messages = 0;
};

/// The messages of one connection in a chunk; times are bag time.
struct ChunkShare {
  std::uint32_t connection = 0;
  std::uint64_t messages = 0;
  ros::Time begin = ros::TIME_MAX;  ///< of the earliest message
  ros::Time end = ros::TIME_MIN;    ///< of the latest message

  void add(const ros::Time& time);
};

struct BagChunk {
  std::uint64_t position = 0;  ///< of its record in the file
  std::vector<ChunkShare> shares;

  ChunkShare& shareOf(std::uint32_t connection);
};

/// Contents of a bag (format 2.0) and their places, without the messages: about 30 bytes per chunk
/// and topic.
struct BagContents {
  std::vector<BagConnection> connections;  ///< those with messages, by id
  std::vector<BagChunk> chunks;            ///< in the order of the index or, without one, the file
  std::uint64_t end_of_chunks = 0;         ///< in the file
  ros::Time begin = ros::TIME_MAX;         ///< bag time of the earliest message
  ros::Time end = ros::TIME_MIN;           ///< bag time of the latest message

  std::uint64_t messages() const;
};

/// Reads the contents from the index. Throws std::runtime_error when there is no index, or it does
/// not fit the file. `on_entry`: gets connection and bag time of each message, chunk by chunk.
BagContents contentsByIndex(
    const std::string& path,
    const std::function<void(std::uint32_t, const ros::Time&)>& on_entry = {});

/// Unreadable parts of a bag.
struct BagLoss {
  std::uint64_t bytes = 0;
  std::uint64_t first = 0;  ///< place of the first of them in the file

  void add(std::uint64_t where, std::uint64_t count);
};

struct BagScan {
  BagContents contents;
  BagLoss loss;
};

/// Reads the contents from the records, from beginning to end: for a bag without an index, for
/// example of a killed recorder, or a bag that was cut. Unreadable parts are skipped and counted.
/// Keeps one chunk in memory. Throws std::runtime_error when the file cannot be read at all.
BagScan contentsByScan(const std::string& path);

/// Name of the plugin that encrypted a bag; empty: not encrypted, or not a bag of format 2.0.
std::string bagEncryptor(const std::string& path);

}  // namespace ring_gyro::bridge
