#pragma once

#include <ros/time.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "ring_gyro/ros/bag_contents.h"
#include "ring_gyro/ros/chunk_merge.h"

namespace ring_gyro::bridge {

/// One line: file, what is wrong, the mend.
class BagError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A bag to be read in the order of bag time, whatever the order in the file (ChunkMerge). One
/// whose index is missing or cut off is read as far as it goes.
class BagFile {
 public:
  /// Throws BagError: not there, not a bag, empty, encrypted.
  explicit BagFile(std::string path);

  const std::string& path() const { return path_; }
  bool hasIndex() const { return has_index_; }
  /// Those with messages, by id.
  const std::vector<BagConnection>& connections() const { return contents_.connections; }
  /// Bag time of the first and the last message of any topic, as rosbag play has it.
  ros::Time begin() const { return contents_.begin; }
  ros::Time end() const { return contents_.end; }

  /// Messages with bag time in [from, to], all of them, the last too, of the connections that have
  /// a sink. Throws what the sinks throw.
  void read(const BagSinks& sinks, const ros::Time& from = ros::TIME_MIN,
            const ros::Time& to = ros::TIME_MAX);

  /// What could not be read up to now, one line each, without the path.
  const std::vector<std::string>& damage() const { return damage_; }
  void addDamage(std::string text) { damage_.push_back(std::move(text)); }
  /// Throws BagError when the index is missing or anything could not be read.
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
