#pragma once

#include <memory>

#include "ring_gyro/ros/bag_file.h"
#include "ring_gyro/ros/conversions.h"

namespace ring_gyro {

/// Has `on_signal` get the signal of each message of this type, of whatever topic. Throws BagError
/// when another version of this package wrote them.
template <typename Message, typename Signal, typename OnSignal>
void addSignals(const BagFile& bag, const OnSignal& on_signal, BagSinks& sinks) {
  for (const BagConnection& connection : bag.connections()) {
    if (connection.type != ros::message_traits::datatype<Message>()) continue;
    if (connection.md5 != ros::message_traits::md5sum<Message>()) {
      throw BagError(bag.path() + ": " + connection.topic + ": " + connection.type +
                     " of another version of this package; read it with that version, or leave it "
                     "out with rosbag filter");
    }
    const auto message = std::make_shared<Message>();
    const auto signal = std::make_shared<Signal>();
    sinks[connection.id] = [=](const BagMessage& found) {
      ros::serialization::IStream stream(found.bytes, found.size);
      ros::serialization::deserialize(stream, *message);
      fromMessage(*message, *signal);
      on_signal(*signal);
    };
  }
}

}  // namespace ring_gyro
