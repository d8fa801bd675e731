#include "ring_gyro/ros/recorded_run.h"

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>

#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/ros/message_checks.h"
#include "ring_gyro/ros/messages.h"
#include "ring_gyro/ros/pair_merge.h"

namespace ring_gyro {
namespace {

/// Rotation of the case by session and sequence, where there is one.
using Rotation = std::map<std::pair<std::uint32_t, std::uint64_t>, double>;

void readTruth(const std::string& path, std::optional<PlantTruth>& truth, Rotation& rotation) {
  rosbag::Bag bag(path);
  rosbag::View view(bag, [](const rosbag::ConnectionInfo* connection) {
    return connection->datatype == ros::message_traits::datatype<ring_gyro_msgs::PlantTruth>();
  });
  for (const rosbag::MessageInstance& instance : view) {
    const auto message = instance.instantiate<ring_gyro_msgs::PlantTruth>();
    if (!message) {
      throw BagError(path + ": " + instance.getTopic() +
                     " is of another version of this package; leave it out with rosbag filter");
    }
    if (faultOf(*message)) continue;
    PlantTruth found;
    fromMessage(*message, found);
    if (found.rotation_rate != 0.0) {
      rotation[{found.stamp.session, found.stamp.sequence}] = found.rotation_rate;
    }
    truth = found;
  }
}

}  // namespace

RecordedRun readRecordedRun(const std::vector<std::string>& paths, const LoopTopics& topics,
                            double start, double duration) {
  std::vector<LoopBag> bags;
  for (const std::string& path : paths) bags.emplace_back(path, topics);
  if (bags.empty()) throw BagError("no bag to read");
  std::stable_sort(bags.begin(), bags.end(),
                   [](const LoopBag& a, const LoopBag& b) { return a.begin() < b.begin(); });
  const ros::Time from = bags.front().begin() + ros::Duration(start);
  const ros::Time to = duration > 0.0 ? from + ros::Duration(duration) : ros::TIME_MAX;

  RecordedRun run;
  Rotation rotation;
  for (const LoopBag& bag : bags) {
    if (bag.hasIndex()) readTruth(bag.path(), run.truth, rotation);
  }
  PairMerge merge([&](const OrbitalElements& elements, const ControlGains& gains) {
    const auto found = rotation.find({elements.stamp.session, elements.stamp.sequence});
    run.pairs.push_back({elements, gains, found == rotation.end() ? 0.0 : found->second});
  });
  OrbitalElements elements;
  ControlGains gains;
  for (LoopBag& bag : bags) {
    bag.read(
        [&](const ring_gyro_msgs::OrbitalElements& message, const ros::Time& /*time*/) {
          readChecked(message, elements);
          merge.add(elements);
        },
        [&](const ring_gyro_msgs::ControlGains& message, const ros::Time& /*time*/) {
          readChecked(message, gains);
          merge.add(gains);
        },
        from, to);
  }
  merge.flush();
  if (run.pairs.empty()) {
    throw BagError(bags.front().path() + ": no elements with gains of the same block in it");
  }
  return run;
}

}  // namespace ring_gyro
