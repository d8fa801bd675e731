#include "ring_gyro/ros/bag_validation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/formatted.h"
#include "ring_gyro/ros/message_checks.h"
#include "ring_gyro/ros/run_ends.h"
#include "ring_gyro/signals/pair_merge.h"

namespace ring_gyro::bridge {
namespace {

constexpr double kLargestAmplitude = 1e3;         // a larger displacement is not in volt
constexpr double kLeastAngle = 0.01;              // a pattern that covers less is at rest [rad]
constexpr double kLargestAngleStep = 1.0;         // of theta in one block [rad]
constexpr double kLargestTimeOffset = 1.0;        // header stamp minus bag time [s]
constexpr double kLargestDelayBlocks = 31.0;      // limit of the identifier
constexpr double kLargestPhase = 2.0 * cvg::kPi;  // |phi| beyond is not in rad

/// Number of occurrences, and the place of the first.
struct Tally {
  std::uint64_t count = 0;
  cvg::BlockStamp first;

  void add(const cvg::BlockStamp& where) {
    if (count++ == 0) first = where;
  }
  std::string at() const {
    return cvg::formatted("%llu times, first in block %llu at %.6f s",
                          static_cast<unsigned long long>(count),
                          static_cast<unsigned long long>(first.sequence), first.end());
  }
};

struct Span {
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -std::numeric_limits<double>::infinity();

  void add(double value) {
    lowest = std::min(lowest, value);
    highest = std::max(highest, value);
  }
  double width() const { return highest - lowest; }
};

/// Checks that each session reaches the block that its plant announced as the last.
class EndCheck {
 public:
  void add(const cvg::BlockStamp& stamp) {
    cvg::BlockStamp& last = last_[stamp.session];
    if (last.end_ns <= stamp.end_ns) last = stamp;
  }

  void report(const RunEnds& ends, std::vector<Finding>& findings) const {
    for (const auto& [session, last] : last_) {
      const auto end = ends.find(session);
      const std::string where = cvg::formatted("block %llu of session %u at %.6f s",
                                               static_cast<unsigned long long>(last.sequence),
                                               static_cast<unsigned>(session), last.end());
      if (end == ends.end()) {
        findings.push_back({Severity::kWarning,
                            "the run was cut after " + where +
                                ": no end_of_run follows; record that topic too, until the end"});
      } else if (end->second > last.sequence) {
        findings.push_back({Severity::kWarning, "the run was cut after " + where +
                                                    ": its last block is " +
                                                    std::to_string(end->second)});
      }
    }
  }

 private:
  std::map<std::uint32_t, cvg::BlockStamp> last_;  // by session
};

/// Stamps of one topic.
class StampCheck {
 public:
  void add(const cvg::BlockStamp& stamp, const ros::Time& bag_time) {
    const cvg::StampOrder order = guard_.check(stamp);
    if (order == cvg::StampOrder::kGap) gaps_.add(stamp);
    if (order == cvg::StampOrder::kStepBack) back_.add(stamp);
    if (order == cvg::StampOrder::kNewSession) sessions_.add(stamp);
    if (order == cvg::StampOrder::kDuplicate) duplicates_.add(stamp);
    if (order == cvg::StampOrder::kLeftSession) left_.add(stamp);
    if (order == cvg::StampOrder::kZero) {
      zero_.add(stamp);
      return;
    }
    if (order == cvg::StampOrder::kNext && stamp.end_ns - last_.end_ns != stamp.duration_ns) {
      spacing_.add(stamp);
    }
    if (std::abs(bag_time.toSec() - stamp.end()) > kLargestTimeOffset) offset_.add(stamp);
    last_ = stamp;
  }

  void report(const std::string& topic, std::vector<Finding>& findings) const {
    const auto add = [&](Severity severity, const Tally& tally, const std::string& what) {
      if (tally.count > 0) findings.push_back({severity, topic + ": " + what + " " + tally.at()});
    };
    add(Severity::kFault, zero_, "stamps that are zero");
    add(Severity::kFault, back_, "stamps step back");
    add(Severity::kFault, spacing_,
        "stamps of successive blocks differ by other than the duration");
    add(Severity::kWarning, gaps_,
        cvg::formatted("%llu blocks missing in gaps",
                       static_cast<unsigned long long>(guard_.counts().lost)));
    add(Severity::kWarning, duplicates_, "the same block again");
    add(Severity::kWarning, sessions_, "a new session of the plant");
    add(Severity::kFault, left_, "a session that had been left goes on, two plants at once?");
    add(Severity::kWarning, offset_, "header and bag time differ by more than 1 s");
  }
  std::uint64_t accepted() const { return guard_.counts().accepted; }

 private:
  cvg::TimeGuard guard_;
  cvg::BlockStamp last_;
  Tally gaps_, back_, sessions_, left_, duplicates_, zero_, spacing_, offset_;
};

/// Impossible numbers, by field and reason.
class NumberCheck {
 public:
  void add(const MessageFault& fault, const cvg::BlockStamp& stamp) {
    if (fault) tallies_[std::string(fault.field) + " " + fault.reason].add(stamp);
  }
  void report(const std::string& topic, std::vector<Finding>& findings) const {
    for (const auto& [what, tally] : tallies_) {
      findings.push_back({Severity::kFault, topic + ": " + what + " " + tally.at()});
    }
  }

 private:
  std::map<std::string, Tally> tallies_;
};

/// Checks the motion from pairs of elements and gains.
class MotionCheck {
 public:
  void add(const cvg::OrbitalElements& elements, const cvg::ControlGains& gains) {
    const cvg::BlockStamp& stamp = elements.stamp;
    const cvg::Orbit& orbit = elements.orbit;
    if (elements.status.refused != cvg::Refusal::kNone ||
        gains.status.refused != cvg::Refusal::kNone)
      return;
    ++blocks_;
    a_.add(orbit.a);
    if (orbit.a > kLargestAmplitude) too_large_.add(stamp);
    if (std::abs(orbit.phi) > kLargestPhase) phase_.add(stamp);
    if (elements.group_delay > kLargestDelayBlocks * stamp.duration()) delay_.add(stamp);
    const bool follows =
        any_ && stamp.session == last_.session && stamp.sequence == last_.sequence + 1;
    if (follows && elements.status.locked() &&
        std::abs(orbit.theta - last_theta_) > kLargestAngleStep) {
      jumps_.add(stamp);
    }
    any_ = true;
    last_ = stamp;
    last_theta_ = orbit.theta;
    if (!elements.status.usable() || !gains.status.usable()) return;
    ++usable_;
    if (!(gains.reference_frequency > 0.0)) frequency_.add(stamp);
    theta_.add(orbit.theta);
    beta_sum_ += gains.beta;
    if (gains.beta != 0.0) beta_given_ = true;
    if (gains.drive.total().squaredNorm() > 0.0) driven_ = true;
  }

  void report(std::vector<Finding>& findings) const {
    const auto fault = [&](const std::string& text) {
      findings.push_back({Severity::kFault, text});
    };
    const auto tally = [&](const Tally& what, const std::string& text) {
      if (what.count > 0) fault(text + " " + what.at());
    };
    tally(too_large_,
          cvg::formatted("a above %g V, is it in mV, nm or counts?", kLargestAmplitude));
    tally(phase_, "|phi| above 2 pi, is it in degrees?");
    tally(delay_, "a group delay above 31 blocks");
    tally(frequency_, "a reference frequency that is not above zero");
    tally(jumps_,
          "theta jumps by more than 1 rad from block to block, is it wrapped or in degrees?");
    if (blocks_ == 0) return;
    if (a_.highest <= 0.0) fault("a is zero throughout: nothing moves, or nothing was measured");
    if (usable_ == 0) {
      fault("no block is locked and free of faults: record until the loops have settled");
      return;
    }
    if (theta_.width() < kLeastAngle) {
      fault(cvg::formatted("theta covers %.1e rad: steer the pattern or turn the gyroscope",
                           theta_.width()));
    }
    if (beta_given_ && beta_sum_ < 0.0) {
      fault("beta has the wrong sign: a sustaining gain is positive (drive along the velocity)");
    }
    if (!driven_) fault("the drive is zero throughout: record the envelopes that were commanded");
  }
  std::uint64_t usable() const { return usable_; }
  double angle() const { return usable_ > 0 ? theta_.width() : 0.0; }

 private:
  bool any_ = false;
  cvg::BlockStamp last_;
  double last_theta_ = 0.0;
  std::uint64_t blocks_ = 0;
  std::uint64_t usable_ = 0;
  Span a_, theta_;
  double beta_sum_ = 0.0;
  bool beta_given_ = false;
  bool driven_ = false;
  Tally too_large_, phase_, delay_, frequency_, jumps_;
};

}  // namespace

bool BagValidation::hasFault() const {
  return std::any_of(findings.begin(), findings.end(),
                     [](const Finding& finding) { return finding.severity == Severity::kFault; });
}

BagValidation validateBag(const std::string& path, const LoopTopics& topics) {
  LoopBag bag(path, topics);
  StampCheck elements_stamps;
  StampCheck gains_stamps;
  NumberCheck elements_numbers;
  NumberCheck gains_numbers;
  MotionCheck motion;
  EndCheck end;
  cvg::PairMerge merge([&motion](const cvg::OrbitalElements& elements,
                                 const cvg::ControlGains& gains) { motion.add(elements, gains); });
  cvg::OrbitalElements elements;
  cvg::ControlGains gains;
  RunEnds ends;
  BagSinks others;
  addRunEnds(bag.file(), ends, others);
  bag.read(
      [&](const ring_gyro::OrbitalElements& message, const ros::Time& time) {
        elements_numbers.add(readChecked(message, elements), elements.stamp);
        elements_stamps.add(elements.stamp, time);
        end.add(elements.stamp);
        merge.add(elements);
      },
      [&](const ring_gyro::ControlGains& message, const ros::Time& time) {
        gains_numbers.add(readChecked(message, gains), gains.stamp);
        gains_stamps.add(gains.stamp, time);
        merge.add(gains);
      },
      ros::TIME_MIN, ros::TIME_MAX, std::move(others));
  merge.flush();

  BagValidation result;
  result.summary = cvg::formatted(
      "%llu orbital elements on %s, %llu control gains on %s, %llu pairs of "
      "which %llu are locked, %.3f turns of theta",
      static_cast<unsigned long long>(elements_stamps.accepted()), bag.elementsTopic().c_str(),
      static_cast<unsigned long long>(gains_stamps.accepted()), bag.gainsTopic().c_str(),
      static_cast<unsigned long long>(merge.counts().pairs),
      static_cast<unsigned long long>(motion.usable()), motion.angle() / cvg::kTwoPi);
  for (const std::string& damage : bag.damage()) {
    result.findings.push_back({Severity::kFault, damage});
  }
  elements_stamps.report(bag.elementsTopic(), result.findings);
  gains_stamps.report(bag.gainsTopic(), result.findings);
  elements_numbers.report(bag.elementsTopic(), result.findings);
  gains_numbers.report(bag.gainsTopic(), result.findings);
  const std::uint64_t alone = merge.counts().elements_alone + merge.counts().gains_alone;
  if (merge.counts().pairs == 0) {
    result.findings.push_back({Severity::kFault, "no elements and gains of the same block"});
  } else if (alone > 0) {
    result.findings.push_back({Severity::kWarning, std::to_string(alone) +
                                                       " messages have no partner on the other "
                                                       "topic"});
  }
  motion.report(result.findings);
  end.report(ends, result.findings);
  return result;
}

}  // namespace ring_gyro::bridge
