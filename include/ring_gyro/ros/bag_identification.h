#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ring_gyro/ros/identification_report.h"
#include "ring_gyro/ros/loop_bag.h"
#include "ring_gyro/ros/stream_identifier.h"
#include "ring_gyro/simulation/loop_configuration.h"

namespace ring_gyro::bridge {

struct BagIdentificationOptions {
  LoopTopics topics;
  double start = 0.0;              ///< after the bag's begin, bag time as in rosbag play [s]
  std::optional<double> duration;  ///< from there; empty: to the end [s]
  std::uint64_t start_sequence = 0;
};

/// Identifies from a recorded run with the code of the node, but without topics: from one bag, or
/// from several bags into which one run was split.
class BagIdentification {
 public:
  using OnEstimate = StreamIdentifier::Sink;
  using OnProgress = std::function<void(double)>;

  /// Opens the bags and sorts them by their start. Throws BagError, and std::invalid_argument when
  /// the configuration cannot be used.
  BagIdentification(const std::vector<std::string>& paths, cvg::LoopConfiguration configuration,
                    BagIdentificationOptions options = {});

  /// Bag time to be read [s].
  double length() const { return (to_ - from_).toSec(); }
  /// `on_estimate` gets each estimate in order; `on_progress` often gets the bag time read so far
  /// [s]. Throws std::runtime_error when an estimate is not finite.
  IdentificationResult run(const OnEstimate& on_estimate = {}, const OnProgress& on_progress = {});

 private:
  cvg::LoopConfiguration configuration_;
  BagIdentificationOptions options_;
  std::vector<LoopBag> bags_;
  ros::Time from_;
  ros::Time to_;
};

}  // namespace ring_gyro::bridge
