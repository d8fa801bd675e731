#include "ring_gyro/ros/run_ends.h"

#include "ring_gyro/ros/message_version.h"
#include "ring_gyro/ros/messages.h"

namespace ring_gyro::bridge {

void addRunEnds(const BagFile& bag, RunEnds& ends, BagSinks& sinks) {
  using ring_gyro::EndOfRun;
  for (const BagConnection& connection : bag.connections()) {
    if (!holds<EndOfRun>(connection)) continue;
    requireVersion<EndOfRun>(bag, connection);
    sinks[connection.id] = [&ends](const BagMessage& found) {
      try {
        EndOfRun end;
        ros::serialization::IStream stream(found.bytes, found.size);
        ros::serialization::deserialize(stream, end);
        ends[end.session] = end.last_sequence;
      } catch (const ros::serialization::StreamOverrunException&) {
        // Damaged message: counts as no announced end.
      }
    };
  }
}

}  // namespace ring_gyro::bridge
