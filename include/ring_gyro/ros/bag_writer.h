#pragma once

#include <rosbag/bag.h>

#include <cerrno>
#include <cstdint>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>

#include "ring_gyro/common/output_file.h"
#include "ring_gyro/ros/messages.h"

namespace ring_gyro::bridge {

/// A bag (lz4) that follows the rules of OutputFile. Until it is complete its name is
/// NAME.xxxxxx.active, with six random characters. A bag that is not finished, or whose writer is
/// killed, keeps that name, and identify and rosbag reindex read it as far as possible. An output
/// that cannot seek (a pipe) gets the whole bag in finish().
///
/// Throws std::runtime_error with one line: path, reason, remedy, and the place of the part that
/// was already written.
class BagWriter {
 public:
  explicit BagWriter(const std::string& path);
  ~BagWriter();
  BagWriter(const BagWriter&) = delete;
  BagWriter& operator=(const BagWriter&) = delete;

  /// Records the message at its own stamp, so that the bag does not depend on the time of writing.
  template <typename Message>
  void write(const std::string& topic, const Message& message) {
    require(topic, message.header.stamp);
    guarded([&] { bag_->write(topic, message.header.stamp, message); });
    ++messages_;
  }

  /// Closes the bag and gives it its final name.
  void finish();
  /// Closes and deletes the bag: for data that turn out to be unusable.
  void discard() noexcept;

  const std::string& path() const { return output_.path(); }
  std::uint64_t messages() const { return messages_; }

 private:
  template <typename Action>
  void guarded(Action action) {
    try {
      errno = 0;  // rosbag does not report why it could not write
      action();
    } catch (const std::exception& error) {
      giveUp(errno, error.what());
    }
  }
  void require(const std::string& topic, const ros::Time& stamp);
  [[noreturn]] void giveUp(int reason, const std::string& what);
  [[noreturn]] void fail(const std::string& fault);
  void close();

  cvg::OutputFile output_;
  std::unique_ptr<rosbag::Bag> bag_;
  std::string fault_;
  std::uint64_t messages_ = 0;
};

}  // namespace ring_gyro::bridge
