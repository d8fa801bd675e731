#include "ring_gyro/ros/recorded_run.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>

#include "ring_gyro/ros/bag_signals.h"
#include "ring_gyro/ros/message_checks.h"
#include "ring_gyro/ros/messages.h"
#include "ring_gyro/signals/pair_merge.h"

namespace ring_gyro::bridge {

RecordedRun readRecordedRun(const std::vector<std::string>& paths, const LoopTopics& topics,
                            double start, double duration) {
  std::vector<LoopBag> bags;
  bags.reserve(paths.size());
  for (const std::string& path : paths) bags.emplace_back(path, topics);
  if (bags.empty()) throw BagError("no bag to read");
  std::stable_sort(bags.begin(), bags.end(),
                   [](const LoopBag& a, const LoopBag& b) { return a.begin() < b.begin(); });
  const ros::Time from = bags.front().begin() + ros::Duration(start);
  const ros::Time to = duration > 0.0 ? from + ros::Duration(duration) : ros::TIME_MAX;

  RecordedRun run;
  // Rotation of the case by session and sequence, if recorded.
  std::map<std::pair<std::uint32_t, std::uint64_t>, double> rotation;
  const auto on_truth = [&](const cvg::PlantTruth& truth) {
    if (truth.rotation_rate != 0.0) {
      rotation[{truth.stamp.session, truth.stamp.sequence}] = truth.rotation_rate;
    }
    run.truth = truth;
  };
  cvg::PairMerge merge([&](const cvg::OrbitalElements& elements, const cvg::ControlGains& gains) {
    run.pairs.push_back({elements, gains});
  });
  cvg::OrbitalElements elements;
  cvg::ControlGains gains;
  const auto asked_for = [&](const ros::Time& time) { return time >= from && time <= to; };
  for (LoopBag& bag : bags) {
    BagSinks truth;
    RefusedMessages refused;  // not reported: the truth is only for comparison
    addSignals<ring_gyro::PlantTruth, cvg::PlantTruth>(bag.file(), on_truth, truth, refused);
    // The truth is read from the whole run, whatever part is requested.
    const bool in_part = truth.empty();
    bag.read(
        [&](const ring_gyro::OrbitalElements& message, const ros::Time& time) {
          if (!asked_for(time)) return;
          readChecked(message, elements);
          merge.add(elements);
        },
        [&](const ring_gyro::ControlGains& message, const ros::Time& time) {
          if (!asked_for(time)) return;
          readChecked(message, gains);
          merge.add(gains);
        },
        in_part ? from : ros::TIME_MIN, in_part ? to : ros::TIME_MAX, std::move(truth));
    for (const std::string& damage : bag.damage()) {
      run.damage.push_back(bag.path() + ": " + damage);
    }
  }
  merge.flush();
  for (RecordedPair& pair : run.pairs) {
    const auto found = rotation.find({pair.elements.stamp.session, pair.elements.stamp.sequence});
    if (found != rotation.end()) pair.rotation_rate = found->second;
  }
  if (run.pairs.empty()) {
    throw BagError(bags.front().path() + ": no elements with gains of the same block in it");
  }
  return run;
}

}  // namespace ring_gyro::bridge
