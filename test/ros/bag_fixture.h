#pragma once

#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "ring_gyro/configuration/configuration_reader.h"
#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/ros/loop_recorder.h"
#include "ring_gyro/ros/messages.h"
#include "ring_gyro/ros/topics.h"
#include "ring_gyro/simulation/closed_loop.h"

namespace ring_gyro::test {

/// Folder that goes away with the test.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    char name[] = "/tmp/ring_gyro_test_XXXXXX";
    if (mkdtemp(name) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~TemporaryFolder() {
    if (std::system(("rm -r '" + path_ + "'").c_str()) != 0) std::perror(path_.c_str());
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

inline std::string contentsOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void writeContents(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<long>(bytes.size()));
}

inline bool exists(const std::string& path) {
  struct stat status = {};
  return stat(path.c_str(), &status) == 0;
}

/// The loop of a preset in one process, recorded. Returns its estimates, as messages.
inline std::vector<ring_gyro::ParameterEstimate> recordRun(
    const cvg::LoopConfiguration& configuration, const std::string& path) {
  cvg::ClosedLoop loop(configuration);
  bridge::LoopRecorder recorder(path, false);
  std::vector<ring_gyro::ParameterEstimate> estimates;
  cvg::BlockStamp last;
  const std::uint64_t blocks = configuration.run.blocks(configuration.converter);
  for (std::uint64_t i = 0; i < blocks; ++i) {
    const cvg::LoopRecord record = loop.step();
    recorder.write(record);
    if (record.estimate) {
      estimates.emplace_back();
      bridge::toMessage(*record.estimate, estimates.back());
    }
    last = record.displacement.stamp;
  }
  recorder.finish(last);
  return estimates;
}

/// How a copy of a recorded run differs from it. What is returned is how often to write the
/// message.
struct BagChange {
  std::function<int(ring_gyro::OrbitalElements&)> elements;
  std::function<int(ring_gyro::ControlGains&)> gains;
  std::string elements_topic = bridge::topics::kOrbitalElements;
  std::string gains_topic = bridge::topics::kControlGains;
  rosbag::CompressionType compression = rosbag::compression::LZ4;
};

template <typename Message>
void copyMessage(const rosbag::MessageInstance& instance, const std::string& topic,
                 const std::function<int(Message&)>& change, rosbag::Bag& to) {
  const auto message = instance.instantiate<Message>();
  if (!message) return;
  const int copies = change ? change(*message) : 1;
  // At the time it had: a recorder's clock does not follow the stamps.
  for (int i = 0; i < copies; ++i) to.write(topic, instance.getTime(), *message);
}

inline void copyBag(const std::string& from_path, const std::string& to_path,
                    const BagChange& change) {
  const rosbag::Bag from(from_path);
  rosbag::Bag to(to_path, rosbag::bagmode::Write);
  to.setCompression(change.compression);
  to.setChunkThreshold(64 * 1024);
  rosbag::View view(from);
  for (const rosbag::MessageInstance& instance : view) {
    copyMessage<ring_gyro::OrbitalElements>(instance, change.elements_topic, change.elements, to);
    copyMessage<ring_gyro::ControlGains>(instance, change.gains_topic, change.gains, to);
  }
  to.close();
}

/// Orders in which the messages of a run may lie in its bag.
enum class BagOrder {
  kBursts,     ///< a thousand blocks of one topic after the other
  kByTopic,    ///< each topic as a whole after the other
  kBackwards,  ///< the last first
  kHalves,     ///< the second half before the first
  kStray       ///< a few early messages at the very end
};

/// A copy with all topics, in another order in the file; bag times stay.
inline void reorderBag(const std::string& from_path, const std::string& to_path, BagOrder order,
                       rosbag::CompressionType compression, std::uint32_t chunk_bytes = 64 * 1024) {
  const rosbag::Bag from(from_path);
  rosbag::View view(from);
  const std::vector<rosbag::MessageInstance> messages(view.begin(), view.end());
  // A message instance cannot be assigned: what is sorted are the places.
  std::vector<std::size_t> places(messages.size());
  std::iota(places.begin(), places.end(), 0u);
  const auto by_topic = [&messages](std::size_t a, std::size_t b) {
    return messages[a].getTopic() < messages[b].getTopic();
  };
  const auto at = [&places](std::size_t place) {
    return places.begin() + static_cast<std::ptrdiff_t>(std::min(place, places.size()));
  };
  constexpr std::size_t kBurst = 3000;
  switch (order) {
    case BagOrder::kBursts:
      for (std::size_t i = 0; i < places.size(); i += kBurst) {
        std::stable_sort(at(i), at(i + kBurst), by_topic);
      }
      break;
    case BagOrder::kByTopic:
      std::stable_sort(places.begin(), places.end(), by_topic);
      break;
    case BagOrder::kBackwards:
      std::reverse(places.begin(), places.end());
      break;
    case BagOrder::kHalves:
      std::rotate(places.begin(), at(places.size() / 2), places.end());
      break;
    case BagOrder::kStray:
      std::rotate(at(100), at(110), places.end());
      break;
  }
  rosbag::Bag to(to_path, rosbag::bagmode::Write);
  to.setCompression(compression);
  to.setChunkThreshold(chunk_bytes);
  for (const std::size_t place : places) {
    const rosbag::MessageInstance& message = messages[place];
    to.write(message.getTopic(), message.getTime(), message, message.getConnectionHeader());
  }
  to.close();
}

}  // namespace ring_gyro::test
