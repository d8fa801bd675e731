#pragma once

#include <ros/time.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "ring_gyro/ros/bag_contents.h"
#include "ring_gyro/ros/chunk_merge.h"

namespace ring_gyro::bridge {

/// One line: file, fault, remedy.
class BagError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A bag that is read in the order of bag time, whatever the order in the file (ChunkMerge). A bag
/// whose index is missing or cut is read as far as possible.
class BagFile {
 public:
  /// Throws BagError when the file does not exist, is not a bag, is empty or encrypted.
  explicit BagFile(std::string path);

  const std::string& path() const { return path_; }
  bool hasIndex() const { return has_index_; }
  /// The connections that have messages, sorted by id.
  const std::vector<BagConnection>& connections() const { return contents_.connections; }
  /// Bag time of the first and the last message of any topic, as in rosbag play.
  ros::Time begin() const { return contents_.begin; }
  ros::Time end() const { return contents_.end; }

  /// Reads all messages with bag time in [from, to], both ends included, of the connections that
  /// have a sink. Throws what the sinks throw.
  void read(const BagSinks& sinks, const ros::Time& from = ros::TIME_MIN,
            const ros::Time& to = ros::TIME_MAX);

  /// Parts that could not be read so far, one line each, without the path.
  const std::vector<std::string>& damage() const { return damage_; }
  void addDamage(std::string text) { damage_.push_back(std::move(text)); }
  /// Throws BagError when the index is missing or a part could not be read.
  void requireWhole() const;

 private:
  [[noreturn]] void fail(const std::string& what) const;
  void scan(const std::string& why);
  std::string lost(const BagLoss& loss) const;

  std::string path_;
  std::uint64_t file_bytes_ = 0;
  bool has_index_ = true;
  BagContents contents_;
  std::vector<std::string> damage_;
};

}  // namespace ring_gyro::bridge
