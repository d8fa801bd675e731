#pragma once

#include <rosbag/bag.h>

#include <cstdint>
#include <string>

#include "ring_gyro/ros/messages.h"

namespace ring_gyro {

/// A bag (lz4) that exists under its name only when it is whole: it is written beside it as
/// NAME.active and renamed by finish(). A bag that is not finished is closed and keeps the other
/// name.
class BagWriter {
 public:
  /// Throws rosbag::BagException when the file cannot be written.
  explicit BagWriter(std::string path);
  ~BagWriter();
  BagWriter(const BagWriter&) = delete;
  BagWriter& operator=(const BagWriter&) = delete;

  /// The message is recorded at its own stamp, so that a bag does not depend on when it was
  /// written.
  template <typename Message>
  void write(const std::string& topic, const Message& message) {
    bag_.write(topic, message.header.stamp, message);
    ++messages_;
  }

  /// Closes and renames. Throws rosbag::BagException or std::runtime_error when that fails.
  void finish();
  /// Closes and deletes: for data that turns out not to be fit for use.
  void discard() noexcept;

  const std::string& path() const { return path_; }
  std::uint64_t messages() const { return messages_; }

 private:
  std::string path_;
  std::string active_path_;
  rosbag::Bag bag_;
  std::uint64_t messages_ = 0;
  bool finished_ = false;
};

}  // namespace ring_gyro
