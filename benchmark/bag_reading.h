#pragma once

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <cstdint>
#include <string>
#include <vector>

namespace ring_gyro::benchmark {

/// Reads orbital elements and control gains with a rosbag::View and drops each message. Returns
/// their number.
inline std::uint64_t readBag(const std::string& path) {
  struct Bytes {
    std::uint8_t* advance(std::uint32_t size) {
      if (bytes.size() < size) bytes.resize(size);
      return bytes.data();
    }
    std::vector<std::uint8_t> bytes;
  };
  const rosbag::Bag bag(path);
  rosbag::View view(bag, [](const rosbag::ConnectionInfo* connection) {
    return connection->datatype == "ring_gyro/OrbitalElements" ||
           connection->datatype == "ring_gyro/ControlGains";
  });
  Bytes bytes;
  std::uint64_t messages = 0;
  for (const rosbag::MessageInstance& instance : view) {
    instance.write(bytes);
    ++messages;
  }
  return messages;
}

}  // namespace ring_gyro::benchmark
