#include "ring_gyro/ros/run_ends.h"

#include "ring_gyro/ros/bag_file.h"
#include "ring_gyro/ros/messages.h"

namespace ring_gyro {

RunEnds runEnds(const std::string& path) {
  using ring_gyro_msgs::EndOfRun;
  RunEnds ends;
  BagFile bag(path);
  BagSinks sinks;
  for (const BagConnection& connection : bag.connections()) {
    if (connection.md5 != ros::message_traits::md5sum<EndOfRun>()) continue;
    sinks[connection.id] = [&ends](const BagMessage& found) {
      try {
        EndOfRun end;
        ros::serialization::IStream stream(found.bytes, found.size);
        ros::serialization::deserialize(stream, end);
        ends[end.session] = end.last_sequence;
      } catch (const ros::serialization::StreamOverrunException&) {
        // Damaged: no end was said here.
      }
    };
  }
  bag.read(sinks);
  return ends;
}

}  // namespace ring_gyro
