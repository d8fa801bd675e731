#include "ring_gyro/identification/block_chain.h"

#include <algorithm>
#include <cmath>

#include "ring_gyro/identification/averaged_model.h"

namespace ring_gyro {
namespace {

/// Finite, an ellipse, and not so large that a square could overflow later.
bool plausible(const OrbitalElements& elements, const ControlGains& gains, double rotation_rate) {
  constexpr double kLimit = 1e12;
  const auto within = [](double x) { return std::abs(x) < kLimit; };  // false for NaN
  const Orbit& orbit = elements.orbit;
  const Eigen::Vector2cd drive = gains.drive.total();
  return within(orbit.a) && within(orbit.b) && within(orbit.theta) && within(orbit.phi) &&
         std::abs(orbit.b) < orbit.a && std::isfinite(elements.group_delay) &&
         within(drive.x().real()) && within(drive.x().imag()) && within(drive.y().real()) &&
         within(drive.y().imag()) && within(gains.reference_phase) &&
         within(gains.reference_frequency) && gains.reference_frequency > 0.0 &&
         within(rotation_rate);
}

}  // namespace

bool BlockChain::admit(const OrbitalElements& elements, const ControlGains& gains,
                       double rotation_rate) {
  const BlockStamp& stamp = elements.stamp;
  const bool paired =
      gains.stamp.session == stamp.session && gains.stamp.sequence == stamp.sequence;
  const bool timed = stamp.end_ns > 0 && stamp.duration_ns == block_duration_ns_;
  if (!paired || !timed || !elements.status.usable() || !gains.status.usable() ||
      !plausible(elements, gains, rotation_rate)) {
    usable_run_ = 0;
    return false;
  }
  const bool follows = usable_run_ > 0 && stamp.session == last_stamp_.session &&
                       stamp.sequence == last_stamp_.sequence + 1 &&
                       stamp.end_ns - last_stamp_.end_ns == block_duration_ns_ &&
                       elements.group_delay == group_delay_;
  if (!follows) {
    usable_run_ = 0;
    if (!setDelay(elements.group_delay, stamp.duration())) return false;
  }
  memory_[stamp.sequence % kMemory] = {elements.orbit, gains.drive.total(), gains.reference_phase,
                                       gains.reference_frequency, rotation_rate};
  last_stamp_ = stamp;
  ++usable_run_;
  return usable_run_ >= filter_memory_;
}

bool BlockChain::setDelay(double group_delay, double duration) {
  const double blocks = group_delay / duration;
  if (!(blocks >= 0.0) || 2.0 * blocks + 2.0 > static_cast<double>(kMemory)) return false;
  // A delay of whole blocks up to rounding has no rest.
  const double whole = std::floor(blocks + 1e-9);
  group_delay_ = group_delay;
  whole_delay_ = static_cast<std::uint64_t>(whole);
  rest_of_delay_ = blocks - whole > 1e-9 ? group_delay - whole * duration : 0.0;
  filter_memory_ =
      std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::ceil(2.0 * blocks - 1e-9)));
  return true;
}

std::array<ChainSegment, 2> BlockChain::segments(std::uint64_t sequence) const {
  const double duration = 1e-9 * static_cast<double>(block_duration_ns_);
  const Block& first = block(sequence - 1 - whole_delay_);
  const Block& then = block(sequence - whole_delay_);
  std::array<ChainSegment, 2> result;
  result[0] = {rest_of_delay_, 0.5 * rest_of_delay_ / duration, first.drive,
               first.reference_frequency, first.rotation_rate};
  const double remaining = duration - rest_of_delay_;
  result[1] = {remaining, 0.5 * (1.0 + rest_of_delay_ / duration),
               then.drive + driveStep(first.drive, then.drive, then.reference_phase,
                                      then.reference_frequency, remaining),
               then.reference_frequency, then.rotation_rate};
  return result;
}

}  // namespace ring_gyro
