#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "ring_gyro/ros/bag_file.h"
#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/ros/message_checks.h"
#include "ring_gyro/ros/message_version.h"

namespace ring_gyro::bridge {

/// Adds a sink, so that `on_message` gets each message of this type from any topic. Throws BagError
/// when another version of this package wrote them.
template <typename Message, typename OnMessage>
void addMessages(const BagFile& bag, const OnMessage& on_message, BagSinks& sinks) {
  for (const BagConnection& connection : bag.connections()) {
    if (!holds<Message>(connection)) continue;
    requireVersion<Message>(bag, connection);
    const auto message = std::make_shared<Message>();
    sinks[connection.id] = [=](const BagMessage& found) {
      ros::serialization::IStream stream(found.bytes, found.size);
      ros::serialization::deserialize(stream, *message);
      on_message(*message);
    };
  }
}

/// Messages that were omitted because of impossible numbers.
struct RefusedMessages {
  std::uint64_t count = 0;
  std::string first;  ///< which, and why

  /// One printed line; empty when there are no such messages.
  std::string text() const {
    return count == 0 ? "" : std::to_string(count) + " messages left out, first " + first;
  }
};

/// Adds a sink, so that `on_signal` gets the signal of each message of this type whose numbers are
/// possible. `refused` must outlive the reading. Throws like addMessages.
template <typename Message, typename Signal, typename OnSignal>
void addSignals(const BagFile& bag, const OnSignal& on_signal, BagSinks& sinks,
                RefusedMessages& refused) {
  const auto signal = std::make_shared<Signal>();
  addMessages<Message>(
      bag,
      [=, &refused](const Message& message) {
        if (const MessageFault fault = faultOf(message)) {
          if (refused.count++ == 0) {
            refused.first = ros::message_traits::datatype<Message>() + std::string(" at ") +
                            std::to_string(message.header.stamp.toSec()) + " s: " + fault.text;
          }
          return;
        }
        fromMessage(message, *signal);
        on_signal(*signal);
      },
      sinks);
}

}  // namespace ring_gyro::bridge
