#pragma once

#include <rosbag/message_instance.h>

#include <stdexcept>

#include "ring_gyro/ros/conversions.h"

namespace ring_gyro {

/// Takes the signal out of a message of this type; false when it is of another. Throws
/// std::runtime_error when another version of this package wrote it.
template <typename Message, typename Signal>
bool readIf(const rosbag::MessageInstance& instance, Signal& signal) {
  if (instance.getDataType() != ros::message_traits::datatype<Message>()) return false;
  const auto message = instance.instantiate<Message>();
  if (!message) {
    throw std::runtime_error(instance.getTopic() + ": " + instance.getDataType() +
                             " of another version of this package; read it with that version");
  }
  fromMessage(*message, signal);
  return true;
}

}  // namespace ring_gyro
