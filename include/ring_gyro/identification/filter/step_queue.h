#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "ring_gyro/common/lanes.h"
#include "ring_gyro/identification/model/averaged_step.h"

namespace cvg {

/// Steps with the (a, b) measured at their ends. They wait until several can be taken side by side.
/// The queue holds four times as many as there are lanes: the code that takes them runs so seldom
/// that it has left the instruction cache, and this way it is fetched once for all of them.
class StepQueue {
 public:
  static constexpr std::size_t kMost = 4 * kLanes;

  /// `kLanes` steps or, in the last group, fewer.
  struct Group {
    AveragedStep<Lanes> step;
    Lanes a = {};  ///< measured [V]
    Lanes b = {};
  };

  StepQueue() {
    // Lanes without a step are computed too, and would divide by a frequency of zero.
    for (Group& group : groups_) group.step.reference_frequency += 1.0;
  }

  /// size() must be below kMost.
  void push(const AveragedStep<double>& step, const Eigen::Vector2d& measured) {
    Group& group = groups_[size_ / kLanes];
    const std::size_t k = size_ % kLanes;
    group.step.theta[k] = step.theta;
    group.step.pattern_rate[k] = step.pattern_rate;
    group.step.phi[k] = step.phi;
    group.step.reference_frequency[k] = step.reference_frequency;
    group.step.x.re[k] = step.x.re;
    group.step.x.im[k] = step.x.im;
    group.step.y.re[k] = step.y.re;
    group.step.y.im[k] = step.y.im;
    group.step.x_change.re[k] = step.x_change.re;
    group.step.x_change.im[k] = step.x_change.im;
    group.step.y_change.re[k] = step.y_change.re;
    group.step.y_change.im[k] = step.y_change.im;
    group.step.image_angle[k] = step.image_angle;
    group.a[k] = measured[0];
    group.b[k] = measured[1];
    ++size_;
  }
  void clear() { size_ = 0; }
  std::size_t size() const { return size_; }
  /// The group that begins with step `first`, a multiple of kLanes below size().
  const Group& group(std::size_t first) const { return groups_[first / kLanes]; }

 private:
  std::array<Group, kMost / kLanes> groups_;
  std::size_t size_ = 0;
};

}  // namespace cvg
