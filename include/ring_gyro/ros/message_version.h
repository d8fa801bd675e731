#pragma once

#include <ros/message_traits.h>

#include <string>

#include "ring_gyro/ros/bag_file.h"

namespace ring_gyro::bridge {

/// The command that converts the messages of a bag to this version; the new bag is in the same
/// folder under an unused name.
std::string fixCommand(const BagFile& bag);

/// Throws BagError, with that command, unless the messages of a connection have this checksum: C++
/// reads only messages of the present version.
void requireVersion(const BagFile& bag, const BagConnection& connection, const std::string& md5);

template <typename Message>
bool holds(const BagConnection& connection) {
  return connection.type == ros::message_traits::datatype<Message>();
}

template <typename Message>
void requireVersion(const BagFile& bag, const BagConnection& connection) {
  requireVersion(bag, connection, ros::message_traits::md5sum<Message>());
}

}  // namespace ring_gyro::bridge
