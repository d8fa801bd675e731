#include "ring_gyro/ros/loop_bag.h"

#include <rosbag/view.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <mutex>
#include <set>
#include <utility>

#include "ring_gyro/ros/topics.h"

namespace ring_gyro {
namespace {

/// Where rosbag writes the bytes of a message: always the same buffer.
class MessageBytes {
 public:
  std::uint8_t* advance(std::uint32_t size) {
    if (bytes_.size() < size) bytes_.resize(size);
    size_ = size;
    return bytes_.data();
  }
  void clear() { size_ = 0; }
  std::uint8_t* data() { return bytes_.data(); }
  std::uint32_t size() const { return size_; }

 private:
  std::vector<std::uint8_t> bytes_;
  std::uint32_t size_ = 0;
};

template <typename Message>
void take(const SerialisedMessage& serialised, Message& message) {
  ros::serialization::IStream stream(serialised.bytes, serialised.size);
  ros::serialization::deserialize(stream, message);
}

/// Whether bytes are long enough for their type: its frame_id is all that has no fixed length.
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
  std::uint32_t elements_ =
      ros::serialization::serializationLength(ring_gyro_msgs::OrbitalElements());
  std::uint32_t gains_ = ros::serialization::serializationLength(ring_gyro_msgs::ControlGains());
};

bool contains(const std::vector<std::uint32_t>& list, std::uint32_t value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

std::string withoutSlash(const std::string& topic) {
  return !topic.empty() && topic[0] == '/' ? topic.substr(1) : topic;
}

/// "/ns/orbital_elements" is a topic by the name "orbital_elements".
bool hasName(const std::string& topic, const std::string& name) {
  return topic == name || (topic.size() > name.size() &&
                           topic.compare(topic.size() - name.size(), name.size(), name) == 0 &&
                           topic[topic.size() - name.size() - 1] == '/');
}

bool startsLikeABag(const std::string& path) {
  std::string start(8, '\0');
  std::ifstream(path, std::ios::binary).read(&start[0], static_cast<std::streamsize>(start.size()));
  return start == "#ROSBAG ";
}

std::string damageOf(const BagScan& scan) {
  return "cut off or damaged from byte " + std::to_string(scan.first_lost) + " on, " +
         std::to_string(scan.lost_bytes) + " of " + std::to_string(scan.file_bytes) +
         " bytes lost; copy it again, or go on with what is left";
}

}  // namespace

void deserialise(const SerialisedMessage& serialised, ring_gyro_msgs::OrbitalElements& message) {
  take(serialised, message);
}

void deserialise(const SerialisedMessage& serialised, ring_gyro_msgs::ControlGains& message) {
  take(serialised, message);
}

LoopBag::LoopBag(std::string path, const LoopTopics& topics) : path_(std::move(path)) {
  open();
  elements_ = choose<ring_gyro_msgs::OrbitalElements>(topics.elements, topics::kOrbitalElements);
  gains_ = choose<ring_gyro_msgs::ControlGains>(topics.gains, topics::kControlGains);
}

void LoopBag::fail(const std::string& what) const { throw BagError(path_ + ": " + what); }

void LoopBag::open() {
  struct stat status = {};
  if (stat(path_.c_str(), &status) != 0) {
    fail(std::string("cannot be opened: ") + std::strerror(errno) + "; check the path");
  }
  if (!S_ISREG(status.st_mode)) fail("not a file; give the bag itself");
  if (status.st_size == 0) fail("the file is empty; nothing was recorded, record again");
  if (!startsLikeABag(path_)) {
    fail("not a bag, it does not begin with #ROSBAG; a log in another format needs import_csv");
  }
  std::string encryptor;
  try {
    encryptor = bagEncryptor(path_);
    openWithIndex();
  } catch (const BagError&) {
    throw;
  } catch (const std::exception& error) {
    bag_.reset();
    if (!encryptor.empty()) {
      fail("encrypted by " + encryptor + ", which cannot read it (" + error.what() +
           "); make a plain copy where the key is: rosbag decrypt " + path_);
    }
    openByScan(error.what());
  }
}

void LoopBag::openWithIndex() {
  // Bags load plugins for encryption, one at a time.
  static std::mutex one_at_a_time;
  const std::lock_guard<std::mutex> lock(one_at_a_time);
  bag_ = std::make_unique<rosbag::Bag>(path_, rosbag::bagmode::Read);
  rosbag::View view(*bag_);
  for (const rosbag::ConnectionInfo* connection : view.getConnections()) {
    connections_.push_back(
        {connection->id, connection->topic, connection->datatype, connection->md5sum});
  }
  // Not size(), which counts them one by one.
  if (view.begin() == view.end()) fail("no messages in it; record while the loops run");
  begin_ = view.getBeginTime();
  end_ = view.getEndTime();
}

void LoopBag::openByScan(const std::string& why) {
  connections_.clear();
  std::set<std::uint32_t> known;
  BagScanner scanner;
  scanner.on_connection = [this, &known](const BagConnection& connection) {
    if (known.insert(connection.id).second) connections_.push_back(connection);
  };
  BagScan scan;
  try {
    scan = scanner.scan(path_);
  } catch (const std::exception& error) {
    fail(std::string(error.what()) + " (" + why + "); record again, or rosbag migrate");
  }
  if (scan.messages == 0) {
    fail("cut off before the first whole chunk of messages (" + why + "); nothing can be saved");
  }
  begin_ = scan.begin;
  end_ = scan.end;
  if (scan.lost_bytes > 0) {
    damage_.push_back(damageOf(scan));
  } else {
    damage_.push_back("the index is missing, all records are there; make one: rosbag reindex " +
                      path_);
  }
}

template <typename Message>
LoopBag::Topic LoopBag::choose(const std::string& wanted, const char* usual_name) const {
  const std::string type = ros::message_traits::datatype<Message>();
  const std::string md5 = ros::message_traits::md5sum<Message>();
  Topic chosen;
  std::set<std::string> names;
  const BagConnection* other_type = nullptr;
  for (const BagConnection& connection : connections_) {
    const bool asked_for = withoutSlash(connection.topic) == withoutSlash(wanted);
    if (wanted.empty() ? connection.type != type : !asked_for) {
      if (wanted.empty() && hasName(connection.topic, usual_name)) other_type = &connection;
      continue;
    }
    if (connection.type != type) {
      other_type = &connection;
      continue;
    }
    if (connection.md5 != md5) {
      fail("topic " + connection.topic + ": " + type + " of another version of this package (md5 " +
           connection.md5 + ", here " + md5 + "); convert the bag: rosbag fix " + path_ +
           " NEW.bag");
    }
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

bool LoopBag::wanted(std::uint32_t connection) const {
  return contains(elements_.connections, connection) || contains(gains_.connections, connection);
}

LoopBag::Content LoopBag::content(const ros::Time& from, const ros::Time& to) const {
  rosbag::View view(
      *bag_, [this](const rosbag::ConnectionInfo* connection) { return wanted(connection->id); },
      from, to);
  Content content;
  content.messages = view.size();
  if (content.messages > 0) content.last = view.getEndTime();
  return content;
}

void LoopBag::read(const OnElements& on_elements, const OnGains& on_gains, const ros::Time& from,
                   const ros::Time& to) {
  ring_gyro_msgs::OrbitalElements elements;
  ring_gyro_msgs::ControlGains gains;
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
      from, to);
}

void LoopBag::read(const OnSerialised& on_message, const ros::Time& from, const ros::Time& to) {
  if (!bag_) {
    readByScan(on_message, from, to, {});
    return;
  }
  Delivered delivered;
  if (readWithIndex(on_message, from, to, delivered)) return;
  // rosbag may give what is left of a damaged chunk for another one: no more of it.
  const BagScan scan = readByScan(on_message, from, to, delivered);
  if (scan.lost_bytes > 0) damage_.push_back(damageOf(scan));
}

bool LoopBag::readWithIndex(const OnSerialised& on_message, const ros::Time& from,
                            const ros::Time& to, Delivered& delivered) {
  rosbag::View view(
      *bag_, [this](const rosbag::ConnectionInfo* connection) { return wanted(connection->id); },
      from, to);
  // The topic of a message is a reference to that of its connection: its address tells which.
  std::vector<const std::string*> element_topics;
  for (const rosbag::ConnectionInfo* connection : view.getConnections()) {
    if (contains(elements_.connections, connection->id)) {
      element_topics.push_back(&connection->topic);
    }
  }
  const WholeMessage whole;
  MessageBytes bytes;
  SerialisedMessage message;
  for (auto instance = view.begin(); instance != view.end(); ++instance) {
    const std::string* topic = &instance->getTopic();
    message.is_elements =
        std::find(element_topics.begin(), element_topics.end(), topic) != element_topics.end();
    try {
      bytes.clear();
      instance->write(bytes);
    } catch (const ros::Exception&) {
      return false;
    }
    message.bytes = bytes.data();
    message.size = bytes.size();
    message.time = instance->getTime();
    if (!whole(message)) return false;
    ++(message.is_elements ? delivered.elements : delivered.gains);
    on_message(message);
  }
  return true;
}

BagScan LoopBag::readByScan(const OnSerialised& on_message, const ros::Time& from,
                            const ros::Time& to, Delivered delivered) {
  const WholeMessage whole;
  std::uint64_t unreadable = 0;
  BagScanner scanner;
  scanner.on_message = [&](std::uint32_t connection, const ros::Time& time, std::uint8_t* bytes,
                           std::uint32_t size) {
    if (time < from || time > to || !wanted(connection)) return;
    const SerialisedMessage message{contains(elements_.connections, connection), bytes, size, time};
    std::uint64_t& still_known = message.is_elements ? delivered.elements : delivered.gains;
    if (still_known > 0) {
      --still_known;
    } else if (whole(message)) {
      on_message(message);
    } else {
      ++unreadable;
    }
  };
  const BagScan scan = scanner.scan(path_);
  if (unreadable > 0) {
    damage_.push_back(std::to_string(unreadable) +
                      " messages are too short for their type; go on with what is left");
  }
  return scan;
}

}  // namespace ring_gyro
