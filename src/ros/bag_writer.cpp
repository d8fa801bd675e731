#include "ring_gyro/ros/bag_writer.h"

#include <cstdio>

#include "ring_gyro/common/write_fault.h"

namespace ring_gyro::bridge {

BagWriter::BagWriter(const std::string& path)
    : output_(path, ".active", cvg::OutputFile::Access::kSeeking),
      bag_(std::make_unique<rosbag::Bag>()) {
  // Opened by its descriptor, so that no other file under this name can be written instead.
  const std::string file = "/proc/self/fd/" + std::to_string(output_.descriptor());
  guarded([&] { bag_->open(file, rosbag::bagmode::Write); });
  bag_->setCompression(rosbag::compression::LZ4);
}

BagWriter::~BagWriter() {
  try {
    close();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
  }
  if (messages_ > 0) output_.keep();
}

void BagWriter::close() {
  if (!bag_) return;
  guarded([&] { bag_->close(); });
  bag_.reset();
}

void BagWriter::finish() {
  if (!fault_.empty()) throw std::runtime_error(fault_);
  close();
  try {
    output_.finish();
  } catch (const std::exception& error) {
    fail(error.what());
  }
}

void BagWriter::discard() noexcept {
  output_.discard();
  messages_ = 0;
  try {
    close();  // the file has no name any more
  } catch (const std::exception&) {
    // The file is deleted anyway.
  }
}

void BagWriter::require(const std::string& topic, const ros::Time& stamp) {
  if (!fault_.empty()) throw std::runtime_error(fault_);
  if (stamp < ros::TIME_MIN) {
    fail(path() + ": cannot be written: a message on " + topic +
         " has no stamp; a bag is in the order of stamps");
  }
}

void BagWriter::giveUp(int reason, const std::string& what) {
  // After a failed write the bag also throws in close(), and its destructor calls close(): that
  // would end the program. The only way out is not to destroy it.
  static_cast<void>(bag_.release());
  fail(reason != 0 ? cvg::writeFault(path(), reason) : path() + ": cannot be written: " + what);
}

void BagWriter::fail(const std::string& fault) {
  fault_ = fault;
  if (messages_ > 0 && !output_.temporary().empty()) {
    fault_ += "; what came before is in " + output_.temporary();
  }
  throw std::runtime_error(fault_);
}

}  // namespace ring_gyro::bridge
