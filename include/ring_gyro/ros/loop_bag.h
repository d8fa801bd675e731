#pragma once

#include <ros/time.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "ring_gyro/ros/bag_file.h"
#include "ring_gyro/ros/messages.h"

namespace ring_gyro::bridge {

/// Topics to identify from. Empty: the only one of its type.
struct LoopTopics {
  std::string elements;
  std::string gains;
};

/// A serialised message of a bag, long enough for its type.
struct SerialisedMessage {
  bool is_elements = false;  ///< orbital elements, otherwise control gains
  std::uint8_t* bytes = nullptr;
  std::uint32_t size = 0;
  ros::Time time;  ///< of the bag
};
void deserialise(const SerialisedMessage& serialised, ring_gyro::OrbitalElements& message);
void deserialise(const SerialisedMessage& serialised, ring_gyro::ControlGains& message);

/// A recorded run for the identifier: orbital elements and control gains in the order of bag time;
/// other topics are not read. A bag whose index is missing or cut is read as far as possible.
class LoopBag {
 public:
  using OnElements = std::function<void(const ring_gyro::OrbitalElements&, const ros::Time&)>;
  using OnGains = std::function<void(const ring_gyro::ControlGains&, const ros::Time&)>;
  using OnSerialised = std::function<void(const SerialisedMessage&)>;  ///< valid during the call

  /// Throws BagError when the file does not exist, is not a bag, is empty or encrypted, or when a
  /// topic is missing, has another type or another version of the message.
  explicit LoopBag(std::string path, const LoopTopics& topics = {});

  /// Reads all messages with bag time in [from, to], both ends included. Throws what the sinks
  /// throw. `others`: sinks for messages of other connections in the same pass.
  void read(const OnElements& on_elements, const OnGains& on_gains,
            const ros::Time& from = ros::TIME_MIN, const ros::Time& to = ros::TIME_MAX,
            BagSinks others = {});
  /// The same without deserialising the messages.
  void read(const OnSerialised& on_message, const ros::Time& from, const ros::Time& to,
            BagSinks others = {});

  const std::string& path() const { return file_.path(); }
  bool hasIndex() const { return file_.hasIndex(); }
  const BagFile& file() const { return file_; }
  /// Bag time of the first and the last message of any topic, as in rosbag play.
  ros::Time begin() const { return file_.begin(); }
  ros::Time end() const { return file_.end(); }
  const std::string& elementsTopic() const { return elements_.topic; }
  const std::string& gainsTopic() const { return gains_.topic; }
  /// Number of messages that read() would deliver, and the bag time of the last; needs an index.
  struct Content {
    std::uint64_t messages = 0;
    ros::Time last;
  };
  Content content(const ros::Time& from, const ros::Time& to) const;

  /// Parts that could not be read so far, one line each.
  const std::vector<std::string>& damage() const { return file_.damage(); }

 private:
  struct Topic {
    std::string topic;
    std::vector<std::uint32_t> connections;
  };

  template <typename Message>
  Topic choose(const std::string& wanted, const char* usual_name) const;
  [[noreturn]] void fail(const std::string& what) const;

  BagFile file_;
  Topic elements_;
  Topic gains_;
};

}  // namespace ring_gyro::bridge
