#include "ring_gyro/identification/filter/block_chain.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "ring_gyro/common/pairs.h"
#include "ring_gyro/common/vector_dispatch.h"
#include "ring_gyro/identification/model/averaged_model.h"

namespace cvg {
BlockChain::BlockChain(std::int64_t block_duration_ns)
    : block_duration_ns_(block_duration_ns),
      block_duration_(1e-9 * static_cast<double>(block_duration_ns)) {
  // Lanes behind the last block are worked on too: nothing there may be divided by zero.
  for (auto& kind : memory_) kind.fill(1.0);
}

BlockUse BlockChain::admit(const OrbitalElements& elements, const ControlGains& gains,
                           double rotation_rate) {
  const BlockStamp& stamp = elements.stamp;
  const Orbit& orbit = elements.orbit;
  const Eigen::Vector2cd total = gains.drive.total();
  const TwoLanes x = {total.x().real(), total.x().imag()};
  const TwoLanes y = {total.y().real(), total.y().imag()};
  const TwoLanes magnitudes =
      (magnitude(TwoLanes{orbit.a, orbit.b}) + magnitude(TwoLanes{orbit.theta, orbit.phi})) +
      (magnitude(x) + magnitude(y)) +
      (magnitude(TwoLanes{gains.reference_frequency, gains.reference_phase}) +
       magnitude(TwoLanes{gains.compensation.gain1, gains.compensation.gain2})) +
      magnitude(TwoLanes{elements.group_delay, rotation_rate});
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
  const std::size_t at = stamp.sequence % kMemory;
  memory_[kMajor][at] = orbit.a;
  memory_[kMinor][at] = orbit.b;
  memory_[kTheta][at] = orbit.theta;
  memory_[kPhi][at] = orbit.phi;
  memory_[kXReal][at] = x[0];
  memory_[kXImaginary][at] = x[1];
  memory_[kYReal][at] = y[0];
  memory_[kYImaginary][at] = y[1];
  memory_[kPhase][at] = gains.reference_phase;
  memory_[kFrequency][at] = gains.reference_frequency;
  memory_[kRotation][at] = rotation_rate;
  if (at < kLanes) {
    for (auto& kind : memory_) kind[at + kMemory] = kind[at];
  }
  last_stamp_ = stamp;
  ++usable_run_;
  return usable_run_ >= filter_memory_ ? BlockUse::kUsable : BlockUse::kAfterBreak;
}

bool BlockChain::setDelay(double group_delay, double duration) {
  const double blocks = group_delay / duration;
  if (!(blocks >= 0.0) || blocks + 1.0 > static_cast<double>(kReach)) return false;
  // A delay of whole blocks up to rounding has no rest.
  const double whole = std::floor(blocks + 1e-9);
  group_delay_ = group_delay;
  whole_delay_ = static_cast<std::uint64_t>(whole);
  rest_of_delay_ = blocks - whole > 1e-9 ? blocks - whole : 0.0;
  filter_memory_ =
      std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::ceil(2.0 * blocks - 1e-9)));
  return true;
}

BlockChain::Block BlockChain::block(std::uint64_t sequence) const {
  const auto number = [&](Kind kind) { return memory_[kind][sequence % kMemory]; };
  Block block;
  block.orbit = {number(kMajor), number(kMinor), number(kTheta), number(kPhi)};
  block.drive << std::complex<double>(number(kXReal), number(kXImaginary)),
      std::complex<double>(number(kYReal), number(kYImaginary));
  block.reference_phase = number(kPhase);
  block.reference_frequency = number(kFrequency);
  block.rotation_rate = number(kRotation);
  return block;
}

std::array<ChainSegment, 2> BlockChain::segments(std::uint64_t sequence) const {
  const double before = block(sequence - 1).orbit.theta;
  const double change = block(sequence).orbit.theta - before;
  const Block first = block(sequence - 1 - whole_delay_);
  const Block then = block(sequence - whole_delay_);
  const double rest = rest_of_delay_ * block_duration_;
  const double remaining = block_duration_ - rest;
  const auto segment = [&](double duration, double middle, const Eigen::Vector2cd& drive,
                           const Block& of) {
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

/// Both moments lie the rest of the delay before the end of a block; drive and frequency change in
/// between. One step takes both drives to second order: their means are those that a response which
/// decays meets at the end of the step, for which what is late counts more, and a change of drive
/// late in the step meets a pattern that has turned on.
template <typename Real>
inline void BlockChain::stepTo(std::uint64_t sequence, double decay_rate,
                               AveragedStep<Real>& step) const {
  Real theta, phi, theta_change, phi_change;
  fetch(kTheta, sequence - 1, theta);
  fetch(kPhi, sequence - 1, phi);
  fetch(kTheta, sequence, theta_change);
  fetch(kPhi, sequence, phi_change);
  theta_change -= theta;
  phi_change -= phi;
  const std::uint64_t acted_then = sequence - whole_delay_;
  Real first_frequency, then_frequency, phase;
  fetch(kFrequency, acted_then - 1, first_frequency);
  fetch(kFrequency, acted_then, then_frequency);
  fetch(kPhase, acted_then, phase);

  const double decay = decay_rate * block_duration_;
  const double middle = 0.5 + decay / 12.0;  // of the weights e^(-decay (1 - s)), 0 <= s <= 1
  const double share = rest_of_delay_;
  const double moment = 0.5 * share * (1.0 - share);  // of a unit step about the middle
  const double first = share - moment * decay;
  const double then = 1.0 - first;

  step.theta = theta + middle * theta_change;
  step.phi = phi + middle * phi_change;
  step.pattern_rate = theta_change * (1.0 / block_duration_);
  step.reference_frequency = first * first_frequency + then * then_frequency;
  step.image_angle = -2.0 * phase;
  const Real then_inverse = 1.0 / then_frequency;
  const Real spread = (0.5 / block_duration_) * then_inverse;
  // A drive acts in proportion to 1 / w, and less by a sinc where the pattern turns away under it.
  const Real scale = (1.0 - theta_change * theta_change * (1.0 / 24.0)) * step.reference_frequency;
  const Real first_scale = first * scale / first_frequency;
  const Real then_scale = then * scale * then_inverse;
  const auto mean = [&](Kind kind, Real& drive, Real& change) {
    Real before;
    fetch(kind, acted_then - 1, before);
    fetch(kind, acted_then, change);
    drive = first_scale * before + then_scale * change;
    change -= before;
  };
  Real xr, xi, yr, yi;
  mean(kXReal, step.x_real, xr);
  mean(kXImaginary, step.x_imaginary, xi);
  mean(kYReal, step.y_real, yr);
  mean(kYImaginary, step.y_imaginary, yi);
  // Turning the pattern turns Fx into Fy and Fy into -Fx; turning phi multiplies both by -i.
  const Real theta_late = moment * theta_change;
  const Real phi_late = moment * phi_change;
  step.x_real += theta_late * yr + phi_late * xi;
  step.x_imaginary += theta_late * yi - phi_late * xr;
  step.y_real += phi_late * yi - theta_late * xr;
  step.y_imaginary -= theta_late * xi + phi_late * yr;
  step.x_step_real = spread * xr;
  step.x_step_imaginary = spread * xi;
  step.y_step_real = spread * yr;
  step.y_step_imaginary = spread * yi;
}

RING_GYRO_FUSED_CLONES RING_GYRO_FLATTEN void BlockChain::step(std::uint64_t sequence,
                                                               double decay_rate,
                                                               AveragedStep<double>& step) const {
  stepTo(sequence, decay_rate, step);
}

RING_GYRO_VECTOR_CLONES RING_GYRO_FLATTEN void BlockChain::steps(std::uint64_t sequence,
                                                                 double decay_rate,
                                                                 AveragedStep<Lanes>& steps) const {
  stepTo(sequence, decay_rate, steps);
}

}  // namespace cvg
