#include "ring_gyro/analysis/run_record.h"

#include <stdexcept>
#include <string>

#include "ring_gyro/demodulation/orbit.h"

namespace cvg {

RunBlock& RunRecord::at(const BlockStamp& stamp) {
  constexpr std::uint64_t kLongestGap = 10'000'000;  // blocks: hours
  if (blocks_.empty()) {
    session_ = stamp.session;
    first_sequence_ = stamp.sequence;
    start_ns_ = stamp.end_ns - stamp.duration_ns;
    duration_ns_ = stamp.duration_ns;
    blocks_.emplace_back();
  }
  if (stamp.session != session_) {
    throw std::invalid_argument("two sessions, " + std::to_string(session_) + " and " +
                                std::to_string(stamp.session) +
                                ": a summary is of one run of the plant");
  }
  const std::uint64_t last_sequence = first_sequence_ + blocks_.size() - 1;
  if (stamp.sequence + kLongestGap < first_sequence_ ||
      stamp.sequence > last_sequence + kLongestGap) {
    throw std::invalid_argument("block " + std::to_string(stamp.sequence) + " after blocks " +
                                std::to_string(first_sequence_) + " to " +
                                std::to_string(last_sequence) + ": not one run");
  }
  while (stamp.sequence < first_sequence_) {
    blocks_.emplace_front();
    --first_sequence_;
    start_ns_ = stamp.end_ns - stamp.duration_ns;
  }
  const std::uint64_t index = stamp.sequence - first_sequence_;
  if (index >= blocks_.size()) blocks_.resize(index + 1);
  RunBlock& block = blocks_[index];
  block.end_ns = stamp.end_ns;
  return block;
}

void RunRecord::add(const OrbitalElements& elements) {
  RunBlock& block = at(elements.stamp);
  block.has_elements = true;
  block.measured = elements.orbit;
  block.status = elements.status;
  group_delay_ = elements.group_delay;
}

void RunRecord::add(const ControlGains& gains) {
  RunBlock& block = at(gains.stamp);
  block.has_gains = true;
  block.beta = gains.beta;
  block.alpha = gains.alpha;
  block.virtual_rate = gains.virtual_rate;
  block.reference_frequency = gains.reference_frequency;
  block.compensation = gains.compensation;
}

void RunRecord::add(const PlantTruth& truth) {
  RunBlock& block = at(truth.stamp);
  block.has_truth = true;
  block.truth = orbitFromEnvelope(truth.envelope);
  rotated_ = rotated_ || truth.rotation_rate != 0.0;
  if (!device_ || device_->stamp.sequence <= truth.stamp.sequence) device_ = truth;
}

void RunRecord::add(const ParameterEstimate& estimate) {
  at(estimate.stamp);
  estimates_.push_back(estimate);
}

void RunRecord::end(std::uint32_t session, std::uint64_t last_sequence) {
  ends_[session] = last_sequence;
}

bool RunRecord::cut() const {
  const auto end = ends_.find(session_);
  return end == ends_.end() || first_sequence_ + blocks_.size() <= end->second;
}

}  // namespace cvg
