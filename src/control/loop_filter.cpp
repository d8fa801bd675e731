#include "ring_gyro/control/loop_filter.h"

#include <algorithm>

#include "ring_gyro/common/angle.h"

namespace cvg {

LoopGains loopGains(double bandwidth, double damping, double decay) {
  const double natural = kTwoPi * bandwidth;
  return {2.0 * damping * natural - decay, natural * natural};
}

LoopFilter::LoopFilter(LoopGains gains, double period, double lowest, double highest)
    : gains_(gains), period_(period), lowest_(lowest), highest_(highest) {}

double LoopFilter::update(double error, double beside) {
  const double lowest = lowest_ - beside;
  const double highest = highest_ - beside;
  const double integral = integral_ + gains_.integral * period_ * error;
  const double wanted = gains_.proportional * error + integral;
  const double output = std::min(std::max(wanted, lowest), highest);
  const bool pushes_out = (wanted > highest && error > 0.0) || (wanted < lowest && error < 0.0);
  if (!pushes_out) integral_ = std::min(std::max(integral, lowest), highest);
  return output;
}

}  // namespace cvg
