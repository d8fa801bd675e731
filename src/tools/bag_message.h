#pragma once

#include <rosbag/message_instance.h>

#include <cstdint>
#include <stdexcept>
#include <string>

#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/ros/message_checks.h"

namespace ring_gyro {

/// Messages that were left out for numbers that cannot be.
struct RefusedMessages {
  std::uint64_t count = 0;
  std::string first;  ///< which, and why

  /// One line for people; empty when there is none.
  std::string text() const {
    return count == 0 ? "" : std::to_string(count) + " messages left out, first " + first;
  }
};

/// Takes the signal out of a message of this type; false when it is of another, or its numbers
/// cannot be. Throws std::runtime_error when another version of this package wrote it.
template <typename Message, typename Signal>
bool readIf(const rosbag::MessageInstance& instance, Signal& signal, RefusedMessages& refused) {
  if (instance.getDataType() != ros::message_traits::datatype<Message>()) return false;
  const auto message = instance.instantiate<Message>();
  if (!message) {
    throw std::runtime_error(instance.getTopic() + ": " + instance.getDataType() +
                             " of another version of this package; read it with that version");
  }
  if (const MessageFault fault = faultOf(*message)) {
    if (refused.count++ == 0) {
      refused.first = instance.getTopic() + " at " + std::to_string(message->header.stamp.toSec()) +
                      " s: " + fault.text;
    }
    return false;
  }
  fromMessage(*message, signal);
  return true;
}

}  // namespace ring_gyro
