#include "ring_gyro/ros/run_ends.h"

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <set>

#include "ring_gyro/ros/bag_scanner.h"
#include "ring_gyro/ros/messages.h"

namespace ring_gyro {
namespace {

using ring_gyro_msgs::EndOfRun;

RunEnds withIndex(const std::string& path) {
  RunEnds ends;
  const rosbag::Bag bag(path);
  rosbag::View view(bag, rosbag::TypeQuery(ros::message_traits::datatype<EndOfRun>()));
  for (const rosbag::MessageInstance& instance : view) {
    if (const auto end = instance.instantiate<EndOfRun>()) ends[end->session] = end->last_sequence;
  }
  return ends;
}

RunEnds byScan(const std::string& path) {
  RunEnds ends;
  std::set<std::uint32_t> connections;
  BagScanner scanner;
  scanner.on_connection = [&connections](const BagConnection& connection) {
    if (connection.md5 == ros::message_traits::md5sum<EndOfRun>()) {
      connections.insert(connection.id);
    }
  };
  scanner.on_message = [&](std::uint32_t connection, const ros::Time&, std::uint8_t* bytes,
                           std::uint32_t size) {
    if (connections.count(connection) == 0) return;
    try {
      EndOfRun end;
      ros::serialization::IStream stream(bytes, size);
      ros::serialization::deserialize(stream, end);
      ends[end.session] = end.last_sequence;
    } catch (const ros::serialization::StreamOverrunException&) {
      // Damaged: no end was said here.
    }
  };
  scanner.scan(path);
  return ends;
}

}  // namespace

RunEnds runEnds(const std::string& path) {
  try {
    return withIndex(path);
  } catch (const rosbag::BagException&) {
    return byScan(path);
  }
}

}  // namespace ring_gyro
