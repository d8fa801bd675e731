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
#include "ring_gyro/ros/stamp_merge.h"

namespace ring_gyro::nodes {

/// Writes a run to a bag, each message at its own stamp and all sorted by stamp (StampMerge), and
/// exits when it has the whole run.
///
/// rosbag record is not enough: it keeps 100 messages per topic and drops more, which a run much
/// faster than real time exceeds, and it does not know when a run is over.
class BagRecorderNode {
 public:
  /// Throws ConfigurationError without a file name, std::runtime_error when the file cannot be
  /// written.
  BagRecorderNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                  const bridge::NodeConfiguration& configuration, NodeHost host);
  ~BagRecorderNode();
  BagRecorderNode(const BagRecorderNode&) = delete;
  BagRecorderNode& operator=(const BagRecorderNode&) = delete;

 private:
  enum class Sent { kEachBlock, kEachPeriod, kOnce };
  struct Topic {
    std::string name;
    ros::Subscriber subscriber;
    std::uint64_t complete_up_to = 0;  // block number
    bool any = false;
  };

  /// `blockOf`: the block up to which a message completes its topic.
  template <typename Message, typename BlockOf>
  void record(const char* topic, BlockOf blockOf, Sent sent = Sent::kEachBlock);
  void reportProcessed();
  void finish();

  ros::NodeHandle handle_;
  NodeHost host_;
  std::uint64_t period_blocks_;  // of the identifier
  std::int64_t period_ns_;       // from the first to the last block of a period
  bridge::BagWriter writer_;
  bridge::StampMerge order_;
  bool finished_ = false;
  std::list<Topic> topics_;
  Departure departure_;
};

}  // namespace ring_gyro::nodes
