#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/single_subscriber_publisher.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace ring_gyro {

/// A topic that a node publishes, with queues that lose nothing, and who listens to it by name.
class Output {
 public:
  Output() = default;

  /// `handle` must use the callback queue of the node. Latched: late listeners get the last
  /// message.
  template <typename Message>
  static Output advertise(ros::NodeHandle& handle, const std::string& topic, bool latched = false) {
    Output output;
    const std::shared_ptr<Names> names = output.names_;
    output.publisher_ = handle.advertise<Message>(
        topic, kUnlimited,
        [names](const ros::SingleSubscriberPublisher& who) {
          add(*names, who.getSubscriberName());
        },
        [names](const ros::SingleSubscriberPublisher& who) {
          remove(*names, who.getSubscriberName());
        },
        ros::VoidConstPtr(), latched);
    return output;
  }

  template <typename MessagePointer>
  void publish(const MessagePointer& message) const {
    publisher_.publish(message);
  }

  std::size_t subscribers() const { return publisher_.getNumSubscribers(); }
  std::string topic() const { return publisher_.getTopic(); }
  /// Nodes that listen, "/a, /b"; "nobody".
  std::string listeners() const;

 private:
  using Names = std::vector<std::string>;
  static constexpr std::uint32_t kUnlimited = 0;

  static void add(Names& names, const std::string& name);
  static void remove(Names& names, const std::string& name);

  ros::Publisher publisher_;
  std::shared_ptr<Names> names_ = std::make_shared<Names>();
};

}  // namespace ring_gyro
