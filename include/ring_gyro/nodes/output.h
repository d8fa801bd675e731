#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/serialization.h>
#include <ros/single_subscriber_publisher.h>
#include <ros/topic_manager.h>

#include <atomic>
#include <boost/shared_array.hpp>
#include <boost/shared_ptr.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <typeinfo>
#include <vector>

#include "ring_gyro/nodes/queue_limits.h"

namespace ring_gyro::nodes {

/// A topic that a node publishes. Knows its subscribers by name, and how many messages the slowest
/// subscriber in another process is behind. Each subscriber has a queue of kOutputQueue messages;
/// if it is full, the subscriber loses the oldest message and sees this by sequence.
class Output {
 public:
  Output() = default;

  /// `handle` must use the callback queue of the node. Latched: late subscribers get the last
  /// message.
  template <typename Message>
  static Output advertise(ros::NodeHandle& handle, const std::string& topic, bool latched = false) {
    Output output;
    const std::shared_ptr<Names> names = output.names_;
    output.latched_ = latched;
    output.publisher_ = handle.advertise<Message>(
        topic, kOutputQueue,
        [names](const ros::SingleSubscriberPublisher& who) {
          add(*names, who.getSubscriberName());
        },
        [names](const ros::SingleSubscriberPublisher& who) {
          remove(*names, who.getSubscriberName());
        },
        ros::VoidConstPtr(), latched);
    output.topic_ = output.publisher_.getTopic();
    return output;
  }

  template <typename Message>
  void publish(const boost::shared_ptr<Message>& message) const {
    if (latched_) {
      publisher_.publish(message);
      return;
    }
    if (waiting() >= kOutputQueue) ++transit_->overflows;
    // Like ros::Publisher, but with a buffer that reports when it has been sent.
    ros::SerializedMessage shared;
    shared.type_info = &typeid(Message);
    shared.message = message;
    ros::TopicManager::instance()->publish(
        topic_, [this, &message] { return inTransit(*message); }, shared);
  }

  /// Number of messages on the way to the slowest reader in another process; latched topics: 0.
  std::size_t waiting() const { return transit_->waiting.load(std::memory_order_relaxed); }
  /// How often a reader lost a message because its queue was full when the next was published.
  std::uint64_t overflows() const { return transit_->overflows; }

  std::size_t subscribers() const { return publisher_.getNumSubscribers(); }
  const std::string& topic() const { return topic_; }
  bool hasListener(const std::string& node) const;
  /// Names of the subscribed nodes, "/a, /b", or "nobody".
  std::string listeners() const;

 private:
  using Names = std::vector<std::string>;
  struct Transit {
    std::atomic<std::size_t> waiting{0};
    std::uint64_t overflows = 0;
  };

  static void add(Names& names, const std::string& name);
  static void remove(Names& names, const std::string& name);

  template <typename Message>
  ros::SerializedMessage inTransit(const Message& message) const {
    ros::SerializedMessage serialised = ros::serialization::serializeMessage(message);
    const boost::shared_array<std::uint8_t> bytes = serialised.buf;
    transit_->waiting.fetch_add(1, std::memory_order_relaxed);
    serialised.buf.reset(bytes.get(), [bytes, transit = transit_](std::uint8_t*) {
      transit->waiting.fetch_sub(1, std::memory_order_relaxed);
    });
    return serialised;
  }

  bool latched_ = false;
  std::string topic_;
  ros::Publisher publisher_;
  std::shared_ptr<Transit> transit_ = std::make_shared<Transit>();
  std::shared_ptr<Names> names_ = std::make_shared<Names>();
};

}  // namespace ring_gyro::nodes
