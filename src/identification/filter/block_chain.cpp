#include "ring_gyro/identification/filter/block_chain.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "ring_gyro/common/small_algebra.h"
#include "ring_gyro/common/vector_dispatch.h"
#include "ring_gyro/identification/model/averaged_model.h"

namespace cvg {

BlockChain::BlockChain(std::int64_t block_duration_ns)
    : block_duration_ns_(block_duration_ns),
      block_duration_(1e-9 * static_cast<double>(block_duration_ns)) {}

BlockUse BlockChain::admit(const OrbitalElements& elements, const ControlGains& gains,
                           double rotation_rate) {
  const BlockStamp& stamp = elements.stamp;
  const Orbit& orbit = elements.orbit;
  const Envelope drive = gains.drive.total();
  const Vector2 magnitudes =
      (magnitude(Vector2{orbit.a, orbit.b}) + magnitude(Vector2{orbit.theta, orbit.phi})) +
      (magnitude(Vector2{drive.x().real(), drive.x().imag()}) +
       magnitude(Vector2{drive.y().real(), drive.y().imag()})) +
      (magnitude(Vector2{gains.reference_frequency, gains.reference_phase}) +
       magnitude(Vector2{gains.compensation.gain1, gains.compensation.gain2})) +
      magnitude(Vector2{elements.group_delay, rotation_rate});
  const bool usable =
      gains.stamp.session == stamp.session && gains.stamp.sequence == stamp.sequence &&
      stamp.end_ns > 0 && stamp.duration_ns == block_duration_ns_ && elements.status.usable() &&
      gains.status.usable() && std::abs(orbit.b) < orbit.a && gains.reference_frequency > 0.0 &&
      magnitudes[0] + magnitudes[1] < kLargestBlock;  // false for NaN
  if (!usable) {
    usable_run_ = 0;
    return useOf(elements, gains, magnitudes[0] + magnitudes[1], block_duration_ns_);
  }
  const bool follows = usable_run_ > 0 && stamp.session == last_stamp_.session &&
                       stamp.sequence == last_stamp_.sequence + 1 &&
                       stamp.end_ns - last_stamp_.end_ns == block_duration_ns_ &&
                       elements.group_delay == group_delay_;
  if (!follows) {
    usable_run_ = 0;
    if (!setDelay(elements.group_delay, stamp.duration())) {
      return elements.group_delay < 0.0 ? BlockUse::kImpossible : BlockUse::kGroupDelay;
    }
  }
  blocks_[stamp.sequence % kMemory] = {orbit, drive, gains.reference_phase,
                                       gains.reference_frequency, rotation_rate};
  last_stamp_ = stamp;
  ++usable_run_;
  return usable_run_ >= filter_memory_ ? BlockUse::kUsable : BlockUse::kAfterBreak;
}

bool BlockChain::setDelay(double group_delay, double duration) {
  const double blocks = group_delay / duration;
  if (!(blocks >= 0.0) || blocks > static_cast<double>(kLongestDelay)) return false;
  // A delay that is a whole number of blocks except for rounding has no rest.
  const double whole = std::floor(blocks + 1e-9);
  group_delay_ = group_delay;
  whole_delay_ = static_cast<std::uint64_t>(whole);
  rest_of_delay_ = blocks - whole > 1e-9 ? blocks - whole : 0.0;
  filter_memory_ =
      std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::ceil(2.0 * blocks - 1e-9)));
  return true;
}

std::array<ChainSegment, 2> BlockChain::segments() const {
  const double before = back(1).orbit.theta;
  const double change = back(0).orbit.theta - before;
  const Block& first = back(whole_delay_ + 1);
  const Block& then = back(whole_delay_);
  const double rest = rest_of_delay_ * block_duration_;
  const double remaining = block_duration_ - rest;
  const auto segment = [&](double duration, double middle, const Envelope& drive, const Block& of) {
    return ChainSegment{
        duration,
        middle,
        {drive, of.reference_frequency, before + middle * change, of.rotation_rate}};
  };
  return {segment(rest, 0.5 * rest_of_delay_, first.drive, first),
          segment(remaining, 0.5 * (1.0 + rest_of_delay_),
                  then.drive + driveStep(first.drive, then.drive, then.reference_phase,
                                         then.reference_frequency, remaining),
                  then)};
}

// The step begins and ends at a moment that is the rest of the delay before the end of a block. In
// between, drive and frequency change from those of the block `first` to those of the block `then`.
// One step takes both to second order (docs/filter.md, section 6, with the same letters): q is the
// share of the drive of `first`, z the decay over the step.
RING_GYRO_FUSED_CLONES RING_GYRO_FLATTEN AveragedStep<double> BlockChain::step(
    double decay_rate) const {
  const Block& before = back(1);
  const Block& now = back(0);
  const Block& first = back(whole_delay_ + 1);
  const Block& then = back(whole_delay_);
  const double z = decay_rate * block_duration_;
  const double q = rest_of_delay_;
  // Means with the weights e^{-z (1 - x)}: the effect of an input late in the step, at x near 1,
  // has decayed less at its end.
  const double middle = 0.5 + z / 12.0;
  const double moment = 0.5 * q * (1.0 - q);
  const double first_share = q - z * moment;
  const double then_share = 1.0 - first_share;

  const double theta_change = now.orbit.theta - before.orbit.theta;
  const double phi_change = now.orbit.phi - before.orbit.phi;
  const double w = first_share * first.reference_frequency + then_share * then.reference_frequency;
  AveragedStep<double> step;
  step.theta = before.orbit.theta + middle * theta_change;
  step.phi = before.orbit.phi + middle * phi_change;
  step.pattern_rate = theta_change / block_duration_;
  step.reference_frequency = w;

  // A drive acts in proportion to 1 / w, and is reduced by a sinc where the pattern turns.
  const double sinc = 1.0 - theta_change * theta_change / 24.0;
  const double first_weight = first_share * sinc * w / first.reference_frequency;
  const double then_weight = then_share * sinc * w / then.reference_frequency;
  const Phasor<double> x_change = phasor(then.drive.x() - first.drive.x());
  const Phasor<double> y_change = phasor(then.drive.y() - first.drive.y());
  step.x = first_weight * phasor(first.drive.x()) + then_weight * phasor(then.drive.x());
  step.y = first_weight * phasor(first.drive.y()) + then_weight * phasor(then.drive.y());
  // A change within the step acts on a pattern that has turned further. The derivatives of Fx and
  // Fy by theta are Fy and -Fx, those by phi are -i times Fx and Fy.
  step.x = step.x + moment * (theta_change * y_change - phi_change * timesI(x_change));
  step.y = step.y - moment * (theta_change * x_change + phi_change * timesI(y_change));

  const double spread = 0.5 / (then.reference_frequency * block_duration_);
  step.x_change = spread * x_change;
  step.y_change = spread * y_change;
  step.image_angle = -2.0 * then.reference_phase;
  return step;
}

}  // namespace cvg
