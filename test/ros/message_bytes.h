#pragma once

#include <ros/serialization.h>

#include <cstdint>
#include <vector>

namespace ring_gyro::test {

/// Contents of a message; the sequence number of the header belongs to the transport.
template <typename Message>
std::vector<std::uint8_t> bytesOf(Message message) {
  message.header.seq = 0;
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

}  // namespace ring_gyro::test
