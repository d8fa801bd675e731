#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>

#include <cstdint>
#include <list>
#include <string>

#include "ring_gyro/nodes/departure.h"
#include "ring_gyro/nodes/node_host.h"
#include "ring_gyro/ros/bag_writer.h"
#include "ring_gyro/ros/node_configuration.h"

namespace ring_gyro {

/// Writes a run to a bag, each message at its own stamp, and leaves once it has all of it.
///
/// rosbag record keeps 100 messages a topic and drops what exceeds them, which a run many times
/// faster than real time does; and it does not know when a run is over.
class BagRecorderNode {
 public:
  /// Throws ConfigurationError without a file name, std::runtime_error when it cannot be written.
  BagRecorderNode(ros::NodeHandle handle, ros::NodeHandle private_handle,
                  const NodeConfiguration& configuration, NodeHost host);
  ~BagRecorderNode();
  BagRecorderNode(const BagRecorderNode&) = delete;
  BagRecorderNode& operator=(const BagRecorderNode&) = delete;

 private:
  struct Topic {
    ros::Subscriber subscriber;
    std::uint64_t complete_up_to = 0;  // block
    bool any = false;
  };

  /// `blockOf`: up to which block a message completes its topic.
  template <typename Message, typename BlockOf>
  void record(const char* topic, BlockOf blockOf);
  void reportProcessed();
  void finish();

  ros::NodeHandle handle_;
  NodeHost host_;
  std::uint64_t period_blocks_;  // of the identifier
  BagWriter writer_;
  bool finished_ = false;
  std::list<Topic> topics_;
  Departure departure_;
};

}  // namespace ring_gyro
