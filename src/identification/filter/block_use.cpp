#include "ring_gyro/identification/filter/block_use.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace cvg {
namespace {

BlockUse useOf(Refusal refusal) {
  switch (refusal) {
    case Refusal::kNone:
      return BlockUse::kUsable;
    case Refusal::kNotFinite:
      return BlockUse::kNotFinite;
    case Refusal::kImpossible:
      return BlockUse::kImpossible;
    case Refusal::kContradiction:
      return BlockUse::kContradiction;
  }
  return BlockUse::kImpossible;
}

}  // namespace

std::uint64_t BlockUseCounts::unusable() const {
  return std::accumulate(blocks.begin(), blocks.end(), std::uint64_t{0}) - usable();
}

BlockUseCounts BlockUseCounts::operator-(const BlockUseCounts& earlier) const {
  BlockUseCounts since;
  std::transform(blocks.begin(), blocks.end(), earlier.blocks.begin(), since.blocks.begin(),
                 std::minus<>());
  return since;
}

BlockUse useOf(const OrbitalElements& elements, const ControlGains& gains, double magnitudes,
               std::int64_t block_duration_ns) {
  const BlockStamp& stamp = elements.stamp;
  const LoopStatus& sensed = elements.status;
  const LoopStatus& acted = gains.status;
  const Refusal refusal = sensed.refused != Refusal::kNone ? sensed.refused : acted.refused;
  if (refusal != Refusal::kNone) return useOf(refusal);
  if (!(magnitudes < kLargestBlock)) return BlockUse::kNotFinite;
  if (gains.stamp.session != stamp.session || gains.stamp.sequence != stamp.sequence ||
      stamp.end_ns <= 0) {
    return BlockUse::kOtherBlock;
  }
  if (stamp.duration_ns != block_duration_ns) return BlockUse::kWrongDuration;
  if (!(std::abs(elements.orbit.b) < elements.orbit.a)) return BlockUse::kNoAmplitude;
  if (sensed.invalid_samples || acted.invalid_samples) return BlockUse::kInvalidSamples;
  if (sensed.converter_saturated || acted.converter_saturated || sensed.drive_saturated ||
      acted.drive_saturated) {
    return BlockUse::kSaturated;
  }
  if (!sensed.usable() || !acted.usable()) return BlockUse::kNotLocked;
  if (!(gains.reference_frequency > 0.0)) return BlockUse::kNoFrequency;
  return BlockUse::kUsable;
}

BlockUse useOf(const OrbitalElements& elements, const ControlGains& gains,
               std::int64_t block_duration_ns) {
  const Orbit& orbit = elements.orbit;
  const Envelope drive = gains.drive.total();
  const double magnitudes = std::abs(orbit.a) + std::abs(orbit.b) + std::abs(orbit.theta) +
                            std::abs(orbit.phi) + std::abs(elements.group_delay) +
                            drive.cwiseAbs().sum() + std::abs(gains.reference_frequency) +
                            std::abs(gains.reference_phase) + std::abs(gains.compensation.gain1) +
                            std::abs(gains.compensation.gain2);
  return useOf(elements, gains, magnitudes, block_duration_ns);
}

}  // namespace cvg
