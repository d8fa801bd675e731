#include "ring_gyro/analysis/run_summary.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/identification/judge/consistency.h"

namespace cvg {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

bool isComplete(const RunBlock& block) { return block.has_elements && block.has_gains; }

bool isCompensated(const RunBlock& block) {
  return block.compensation.gain1 != 0.0 || block.compensation.gain2 != 0.0;
}

// Blocks first <= i < end.
struct Span {
  std::size_t first = 0;
  std::size_t end = 0;
  std::size_t size() const { return end - first; }
};

// The longest run of complete, locked blocks at one virtual rate that `belongs` accepts.
template <typename Belongs>
Span longestSpan(const RunRecord& record, std::size_t first, const Belongs& belongs) {
  const auto& blocks = record.blocks();
  Span best;
  Span now;
  const RunBlock* last = nullptr;
  for (std::size_t i = first; i < blocks.size(); ++i) {
    const RunBlock& block = blocks[i];
    if (!isComplete(block)) continue;  // a gap removes only its windows
    if (!block.status.locked() || !belongs(block)) {
      last = nullptr;
      continue;
    }
    if (!last || last->virtual_rate != block.virtual_rate) now.first = i;
    now.end = i + 1;
    last = &block;
    if (now.size() > best.size()) best = now;
  }
  return best;
}

// The blocks at the end of the run in which the compensation has its last value.
Span settledSpan(const RunRecord& record, std::size_t first) {
  constexpr double kSettled = 0.01;
  const auto& blocks = record.blocks();
  Span span{blocks.size(), blocks.size()};
  const RunBlock* last = nullptr;
  for (std::size_t i = blocks.size(); i > first; --i) {
    const RunBlock& block = blocks[i - 1];
    if (!isComplete(block)) continue;
    if (!last) {
      if (!isCompensated(block)) return span;
      last = &block;
      span.end = i;
    }
    const double change = std::hypot(block.compensation.gain1 - last->compensation.gain1,
                                     block.compensation.gain2 - last->compensation.gain2);
    const double size = std::hypot(last->compensation.gain1, last->compensation.gain2);
    if (change > kSettled * size || !block.status.locked() ||
        block.virtual_rate != last->virtual_rate) {
      break;
    }
    span.first = i - 1;
  }
  return span;
}

DriftResult driftIn(const RunRecord& record, const Span& span, double window) {
  DriftResult result;
  if (span.size() == 0) {
    result.missing = "no such blocks";
    return result;
  }
  const auto& blocks = record.blocks();
  for (std::size_t i = span.first; i < span.end; ++i) {
    if (isComplete(blocks[i])) {
      result.angles.push_back({record.time(blocks[i]), blocks[i].measured.theta});
    }
  }
  result.begin_time = result.angles.front().time - record.blockDuration();
  result.end_time = result.angles.back().time;
  result.virtual_rate = blocks[span.end - 1].virtual_rate;
  try {
    result.harmonics = fitRateHarmonics(result.angles, window);
  } catch (const std::invalid_argument& error) {
    result.missing = error.what();
  }
  return result;
}

IdentificationResult identificationAt(const RunRecord& record, const ParameterEstimate& estimate) {
  IdentificationResult result;
  result.time = record.time(estimate.stamp.end_ns);
  result.used_time = static_cast<double>(estimate.used_blocks) * estimate.stamp.duration();
  result.converged = estimate.converged;
  const auto& device = record.device();
  const auto parameter = [&](const char* name, StateIndex index, double PlantTruth::*truth) {
    return ParameterResult{name, index == kDriveGain, device ? (*device).*truth : kUnknown,
                           estimate.value[index], estimate.sigma(index)};
  };
  result.parameters = {parameter("gamma1", kGamma1, &PlantTruth::gamma1),
                       parameter("gamma2", kGamma2, &PlantTruth::gamma2),
                       parameter("mu1", kMu1, &PlantTruth::mu1),
                       parameter("mu2", kMu2, &PlantTruth::mu2),
                       parameter("ks", kDriveGain, &PlantTruth::drive_gain)};
  result.residual_gamma1 = estimate.residual_gamma1;
  result.residual_gamma2 = estimate.residual_gamma2;
  result.angle_covered = estimate.angle_covered;
  result.used_blocks = estimate.used_blocks;
  result.rejected_blocks = estimate.rejected_blocks;
  result.lost_blocks = estimate.lost_blocks;
  return result;
}

std::optional<FilterConsistency> consistencyOf(const RunRecord& record) {
  FilterConsistency result;
  std::size_t inside = 0;
  for (const ParameterEstimate& estimate : record.estimates()) {
    if (!estimate.updated) continue;
    ++result.updates;
    result.mean += estimate.normalised_innovation_squared;
    if (estimate.normalised_innovation_squared < FilterConsistency::kBound) ++inside;
  }
  if (result.updates == 0) return std::nullopt;
  result.mean /= static_cast<double>(result.updates);
  result.share_inside = static_cast<double>(inside) / static_cast<double>(result.updates);
  return result;
}

std::size_t firstLocked(const RunRecord& record) {
  const auto& blocks = record.blocks();
  const auto found = std::find_if(blocks.begin(), blocks.end(), [](const RunBlock& block) {
    return block.has_elements && block.status.locked();
  });
  return static_cast<std::size_t>(found - blocks.begin());
}

std::optional<LoopErrors> loopErrors(const RunRecord& record, std::size_t first) {
  const auto& blocks = record.blocks();
  LoopErrors errors;
  double sum = 0.0;
  double lowest = std::numeric_limits<double>::infinity();
  double highest = 0.0;
  std::size_t count = 0;
  for (std::size_t i = first; i < blocks.size(); ++i) {
    if (!blocks[i].has_truth) continue;
    const Orbit& truth = blocks[i].truth;
    errors.phase = std::max(errors.phase, std::abs(truth.phi + 0.5 * kPi));
    errors.quadrature = std::max(errors.quadrature, std::abs(truth.b) / truth.a);
    lowest = std::min(lowest, truth.a);
    highest = std::max(highest, truth.a);
    sum += truth.a;
    ++count;
  }
  if (count == 0) return std::nullopt;
  const double mean = sum / static_cast<double>(count);
  errors.amplitude = std::max(highest - mean, mean - lowest) / mean;
  errors.from_time = record.time(blocks[first]) - record.blockDuration();
  return errors;
}

}  // namespace

double FilterConsistency::meanTolerance() const {
  return 1.96 * 2.0 / std::sqrt(static_cast<double>(updates));  // the variance of one is 4
}

RunSummary summarise(const RunRecord& record, const SummaryOptions& options) {
  const auto& blocks = record.blocks();
  RunSummary summary;
  if (blocks.empty()) {
    summary.before.missing = summary.after.missing = "the run is empty";
    return summary;
  }
  summary.duration = static_cast<double>(blocks.size()) * record.blockDuration();
  summary.missing_blocks = static_cast<std::size_t>(std::count_if(
      blocks.begin(), blocks.end(), [](const RunBlock& b) { return !isComplete(b); }));

  const std::size_t locked = firstLocked(record);
  std::size_t judged = blocks.size();
  if (locked < blocks.size()) {
    summary.ring_up_time = record.time(blocks[locked]);
    summary.unlocked_blocks = static_cast<std::size_t>(
        std::count_if(blocks.begin() + static_cast<std::ptrdiff_t>(locked), blocks.end(),
                      [](const RunBlock& b) { return b.has_elements && !b.status.locked(); }));
    const auto settling = std::lround(options.settling / record.blockDuration());
    judged = std::min(locked + static_cast<std::size_t>(settling), blocks.size());
    while (judged < blocks.size() && blocks[judged].end_ns == 0) ++judged;
  }
  if (judged < blocks.size()) summary.loop_errors = loopErrors(record, judged);

  summary.before = driftIn(
      record, longestSpan(record, judged, [](const RunBlock& b) { return !isCompensated(b); }),
      options.rate_window);
  summary.after = driftIn(record, settledSpan(record, judged), options.rate_window);

  const auto first_compensated = std::find_if(blocks.begin(), blocks.end(), isCompensated);
  summary.consistency = consistencyOf(record);
  NisTally nis;
  for (const ParameterEstimate& estimate : record.estimates()) {
    if (estimate.updated) {
      nis.add(estimate.normalised_innovation_squared, summary.converged_time.has_value());
    }
    if (!estimate.converged) {
      summary.converged_time.reset();
    } else if (!summary.converged_time) {
      summary.converged_time = record.time(estimate.stamp.end_ns);
    }
    if (!summary.converged_time) nis.startAnew();
    if (!estimate.updated) continue;
    summary.final_estimate = identificationAt(record, estimate);
    if (first_compensated == blocks.end() || estimate.stamp.end_ns < first_compensated->end_ns) {
      summary.before_compensation = summary.final_estimate;
    }
  }
  summary.misfit = nis.misfit();
  return summary;
}

}  // namespace cvg
