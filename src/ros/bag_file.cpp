#include "ring_gyro/ros/bag_file.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include "ring_gyro/common/shell_word.h"

namespace ring_gyro::bridge {
namespace {

bool startsLikeABag(const std::string& path) {
  std::string start(8, '\0');
  std::ifstream(path, std::ios::binary).read(&start[0], static_cast<std::streamsize>(start.size()));
  return start == "#ROSBAG ";
}

}  // namespace

BagFile::BagFile(std::string path) : path_(std::move(path)) {
  struct stat status = {};
  if (stat(path_.c_str(), &status) != 0) {
    fail(std::string("cannot be opened: ") + std::strerror(errno) + "; check the path");
  }
  if (!S_ISREG(status.st_mode)) fail("not a file; give the bag itself");
  if (status.st_size == 0) fail("the file is empty; nothing was recorded, record again");
  file_bytes_ = static_cast<std::uint64_t>(status.st_size);
  if (!startsLikeABag(path_)) {
    fail("not a bag, it does not begin with #ROSBAG; a log in another format needs import_csv");
  }
  const std::string encryptor = bagEncryptor(path_);
  if (!encryptor.empty()) {
    fail("encrypted by " + encryptor + "; make a plain copy where the key is: rosbag decrypt " +
         cvg::shellWord(path_));
  }
  try {
    contents_ = contentsByIndex(path_);
  } catch (const std::exception& error) {
    scan(error.what());
  }
  if (contents_.connections.empty()) fail("no messages in it; record while the loops run");
}

void BagFile::fail(const std::string& what) const { throw BagError(path_ + ": " + what); }

void BagFile::scan(const std::string& why) {
  has_index_ = false;
  BagScan scan;
  try {
    scan = contentsByScan(path_);
  } catch (const std::exception& error) {
    fail(std::string(error.what()) + " (" + why + "); record again, or rosbag migrate");
  }
  contents_ = std::move(scan.contents);
  if (contents_.connections.empty()) {
    fail("cut off before the first whole chunk of messages (" + why + "); nothing can be saved");
  }
  damage_.push_back(scan.loss.bytes > 0
                        ? lost(scan.loss)
                        : "the index is missing, all records are there; make one: rosbag reindex " +
                              cvg::shellWord(path_));
}

std::string BagFile::lost(const BagLoss& loss) const {
  return "cut off or damaged from byte " + std::to_string(loss.first) + " on, " +
         std::to_string(loss.bytes) + " of " + std::to_string(file_bytes_) +
         " bytes lost; copy it again, or go on with what is left";
}

void BagFile::read(const BagSinks& sinks, const ros::Time& from, const ros::Time& to) {
  const ChunkMerge::Outcome outcome = ChunkMerge(path_, contents_, sinks, from, to).run();
  // Without an index the scan has already reported it.
  if (!has_index_ || outcome.loss.bytes == 0) return;
  const std::string text = lost(outcome.loss);
  if (damage_.empty() || damage_.back() != text) damage_.push_back(text);
}

void BagFile::requireWhole() const {
  if (!damage_.empty()) {
    fail(damage_.front() + "; this needs a whole bag: rosbag reindex makes one of what is left");
  }
}

}  // namespace ring_gyro::bridge
