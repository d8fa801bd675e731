#include "ring_gyro/ros/bag_writer.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "ring_gyro/common/whole_file.h"

namespace ring_gyro {

BagWriter::BagWriter(std::string path) : path_(std::move(path)), active_path_(path_ + ".active") {
  try {
    bag_.open(active_path_, rosbag::bagmode::Write);
  } catch (const rosbag::BagException&) {
    throw std::runtime_error(writeFault(path_, errno));
  }
  bag_.setCompression(rosbag::compression::LZ4);
}

BagWriter::~BagWriter() {
  if (finished_) return;
  try {
    bag_.close();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", active_path_.c_str(), error.what());
  }
}

void BagWriter::finish() {
  bag_.close();
  if (std::rename(active_path_.c_str(), path_.c_str()) != 0) {
    throw std::runtime_error(active_path_ + ": cannot be renamed to " + path_ + ": " +
                             std::strerror(errno));
  }
  finished_ = true;
}

void BagWriter::discard() noexcept {
  try {
    bag_.close();
  } catch (const std::exception&) {
    // It is deleted anyway.
  }
  std::remove(active_path_.c_str());
  finished_ = true;
}

}  // namespace ring_gyro
