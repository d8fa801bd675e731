#include "ring_gyro/ros/loop_bag.h"

#include <algorithm>
#include <cstring>
#include <set>
#include <utility>

#include "ring_gyro/ros/message_version.h"
#include "ring_gyro/ros/topics.h"

namespace ring_gyro::bridge {
namespace {

template <typename Message>
void take(const SerialisedMessage& serialised, Message& message) {
  ros::serialization::IStream stream(serialised.bytes, serialised.size);
  ros::serialization::deserialize(stream, message);
}

/// Whether the bytes are long enough for their type; only frame_id has no fixed length.
class WholeMessage {
 public:
  bool operator()(const SerialisedMessage& message) const {
    constexpr std::uint32_t kFrameIdLength = 12;  // after seq and stamp of the header
    if (message.size < kFrameIdLength + sizeof(std::uint32_t)) return false;
    std::uint32_t frame_id = 0;
    std::memcpy(&frame_id, message.bytes + kFrameIdLength, sizeof frame_id);
    return std::uint64_t{frame_id} + (message.is_elements ? elements_ : gains_) <= message.size;
  }

 private:
  std::uint32_t elements_ = ros::serialization::serializationLength(ring_gyro::OrbitalElements());
  std::uint32_t gains_ = ros::serialization::serializationLength(ring_gyro::ControlGains());
};

bool contains(const std::vector<std::uint32_t>& list, std::uint32_t value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

std::string withoutSlash(const std::string& topic) {
  return !topic.empty() && topic[0] == '/' ? topic.substr(1) : topic;
}

/// "/ns/orbital_elements" is a topic with the name "orbital_elements".
bool hasName(const std::string& topic, const std::string& name) {
  return topic == name || (topic.size() > name.size() &&
                           topic.compare(topic.size() - name.size(), name.size(), name) == 0 &&
                           topic[topic.size() - name.size() - 1] == '/');
}

}  // namespace

void deserialise(const SerialisedMessage& serialised, ring_gyro::OrbitalElements& message) {
  take(serialised, message);
}

void deserialise(const SerialisedMessage& serialised, ring_gyro::ControlGains& message) {
  take(serialised, message);
}

LoopBag::LoopBag(std::string path, const LoopTopics& topics) : file_(std::move(path)) {
  elements_ = choose<ring_gyro::OrbitalElements>(topics.elements, topics::kOrbitalElements);
  gains_ = choose<ring_gyro::ControlGains>(topics.gains, topics::kControlGains);
}

void LoopBag::fail(const std::string& what) const { throw BagError(path() + ": " + what); }

template <typename Message>
LoopBag::Topic LoopBag::choose(const std::string& wanted, const char* usual_name) const {
  const std::string type = ros::message_traits::datatype<Message>();
  Topic chosen;
  std::set<std::string> names;
  const BagConnection* other_type = nullptr;
  for (const BagConnection& connection : file_.connections()) {
    const bool asked_for = withoutSlash(connection.topic) == withoutSlash(wanted);
    if (wanted.empty() ? connection.type != type : !asked_for) {
      if (wanted.empty() && hasName(connection.topic, usual_name)) other_type = &connection;
      continue;
    }
    if (connection.type != type) {
      other_type = &connection;
      continue;
    }
    requireVersion<Message>(file_, connection);
    chosen.topic = connection.topic;
    chosen.connections.push_back(connection.id);
    names.insert(connection.topic);
  }
  if (names.size() > 1) {
    fail("two topics of " + type + ", " + *names.begin() + " and " + *names.rbegin() +
         "; choose with --elements TOPIC and --gains TOPIC");
  }
  if (names.empty() && other_type != nullptr) {
    fail("topic " + other_type->topic + " is a " + other_type->type + ", not a " + type +
         "; record the topic of the control loops");
  }
  if (names.empty()) {
    fail((wanted.empty() ? "no topic of type " + type : "no topic " + wanted) + "; record " +
         topics::kOrbitalElements + " and " + topics::kControlGains);
  }
  return chosen;
}

LoopBag::Content LoopBag::content(const ros::Time& from, const ros::Time& to) const {
  Content content;
  contentsByIndex(path(), [&](std::uint32_t connection, const ros::Time& time) {
    if (time < from || time > to ||
        (!contains(elements_.connections, connection) &&
         !contains(gains_.connections, connection))) {
      return;
    }
    content.last = content.messages++ == 0 ? time : std::max(content.last, time);
  });
  return content;
}

void LoopBag::read(const OnElements& on_elements, const OnGains& on_gains, const ros::Time& from,
                   const ros::Time& to, BagSinks others) {
  ring_gyro::OrbitalElements elements;
  ring_gyro::ControlGains gains;
  read(
      [&](const SerialisedMessage& message) {
        if (message.is_elements) {
          deserialise(message, elements);
          on_elements(elements, message.time);
        } else {
          deserialise(message, gains);
          on_gains(gains, message.time);
        }
      },
      from, to, std::move(others));
}

void LoopBag::read(const OnSerialised& on_message, const ros::Time& from, const ros::Time& to,
                   BagSinks others) {
  const WholeMessage whole;
  std::uint64_t unreadable = 0;
  BagSinks sinks = std::move(others);
  const auto add = [&](const Topic& topic, bool is_elements) {
    for (const std::uint32_t connection : topic.connections) {
      sinks[connection] = [&, is_elements](const BagMessage& message) {
        const SerialisedMessage serialised{is_elements, message.bytes, message.size, message.time};
        if (whole(serialised)) {
          on_message(serialised);
        } else {
          ++unreadable;
        }
      };
    }
  };
  add(elements_, true);
  add(gains_, false);
  file_.read(sinks, from, to);
  if (unreadable > 0) {
    file_.addDamage(std::to_string(unreadable) +
                    " messages are too short for their type; go on with what is left");
  }
}

}  // namespace ring_gyro::bridge
