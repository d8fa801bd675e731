#pragma once

#include <ros/time.h>

#include <cstdint>
#include <functional>
#include <string>

namespace ring_gyro {

/// One topic as one publisher gave it.
struct BagConnection {
  std::uint32_t id = 0;
  std::string topic;
  std::string type;
  std::string md5;
};

/// What was and was not readable of a bag.
struct BagScan {
  std::uint64_t file_bytes = 0;
  std::uint64_t lost_bytes = 0;     ///< that could not be read
  std::uint64_t first_lost = 0;     ///< where in the file the first of them is
  std::uint64_t messages = 0;       ///< of all topics
  ros::Time begin = ros::TIME_MAX;  ///< bag time of the earliest
  ros::Time end = ros::TIME_MIN;    ///< and of the latest message
};

/// Reads a bag (format 2.0) from front to back by its records alone: a bag without an index, as a
/// recorder leaves it that was killed, or one that was cut off. What cannot be read is passed over
/// and counted. Holds one chunk in memory.
struct BagScanner {
  std::function<void(const BagConnection&)> on_connection;
  /// Connection, bag time, serialised message, its length.
  std::function<void(std::uint32_t, const ros::Time&, std::uint8_t*, std::uint32_t)> on_message;

  /// Throws std::runtime_error when the file cannot be read at all.
  BagScan scan(const std::string& path) const;
};

/// Name of the plugin that encrypted a bag; empty: not encrypted, or no bag.
std::string bagEncryptor(const std::string& path);

}  // namespace ring_gyro
