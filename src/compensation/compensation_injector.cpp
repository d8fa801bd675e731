#include "ring_gyro/compensation/compensation_injector.h"

#include <cmath>
#include <stdexcept>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/square.h"
#include "ring_gyro/signals/compensation_decision.h"

namespace cvg {
namespace {

/// A sum is finite only if all its terms are.
bool finite(const ParameterEstimate& estimate) {
  return std::isfinite(estimate.value.sum() + estimate.parameter_variance.sum());
}

}  // namespace

void InjectorParameters::declare(ParameterTable& table) {
  table.flag("enabled", enabled, "whether compensation may begin; can be switched while running")
      .number("start_after", start_after, "s", Range::atLeast(0.0),
              "time of data that the identifier must have used before compensation begins")
      .number("gamma_sigma_limit", gamma_sigma_limit, "1", Range::above(0.0),
              "compensation follows only estimates with both sigmas of gamma below this")
      .number("gamma_limit", gamma_limit, "1", Range::between(0.0, 1.0),
              "largest |gamma| that is compensated; estimates beyond it are not followed")
      .number("ramp_rate", ramp_rate, "1/s", Range::above(0.0),
              "how fast the compensated gamma moves to its target");
}

CompensationInjector::CompensationInjector(const DeviceKnowledge& device,
                                           const InjectorParameters& parameters,
                                           std::int64_t period_blocks)
    : parameters_(checked(parameters, "compensation")),
      damping_(2.0 * device.decayRate()),
      period_blocks_(period_blocks),
      enabled_(parameters.enabled) {
  device.requireResonance("compensation");
  if (period_blocks < 1) {
    throw std::invalid_argument("compensation: period_blocks must be at least 1");
  }
}

const CompensationDecision& CompensationInjector::decide(const ParameterEstimate& estimate) {
  if (!begun_ || estimate.stamp.session != session_) {
    reset();
    begun_ = true;
    session_ = estimate.stamp.session;
  }
  const double period = static_cast<double>(period_blocks_) * estimate.stamp.duration();

  if (!enabled_) {
    rampTowards(0.0, 0.0, period);
    decision_.state = InjectorState::kDisabled;
  } else if (hold_) {
    decision_.state = InjectorState::kHolding;
  } else if (!gateOpen(estimate)) {
    decision_.state = InjectorState::kWaiting;
  } else if (square(estimate.value[kGamma1]) + square(estimate.value[kGamma2]) >
             square(parameters_.gamma_limit)) {
    decision_.state = InjectorState::kLimited;
  } else {
    drive_gain_ = estimate.value[kDriveGain];
    rampTowards(estimate.value[kGamma1], estimate.value[kGamma2], period);
    decision_.state = InjectorState::kTracking;
  }

  decision_.session = session_;
  decision_.data_sequence = estimate.stamp.sequence;
  decision_.effective_sequence =
      estimate.stamp.sequence + 1 + static_cast<std::uint64_t>(period_blocks_);
  decision_.gamma1 = gamma1_;
  decision_.gamma2 = gamma2_;
  const double gain = drive_gain_ > 0.0 ? damping_ / drive_gain_ : 0.0;
  decision_.gains = {gain * gamma1_, gain * gamma2_};
  return decision_;
}

void CompensationInjector::reset() {
  gamma1_ = 0.0;
  gamma2_ = 0.0;
  drive_gain_ = 0.0;
}

bool CompensationInjector::gateOpen(const ParameterEstimate& estimate) const {
  const double used = static_cast<double>(estimate.used_blocks) * estimate.stamp.duration();
  return finite(estimate) && estimate.converged && estimate.value[kDriveGain] > 0.0 &&
         estimate.variance(kGamma1) <= square(parameters_.gamma_sigma_limit) &&
         estimate.variance(kGamma2) <= square(parameters_.gamma_sigma_limit) &&
         used >= parameters_.start_after;
}

/// Moves in a straight line of (gamma1, gamma2), so that the axis of the cancelled mismatch does
/// not change during the ramp.
void CompensationInjector::rampTowards(double gamma1, double gamma2, double duration) {
  const double step1 = gamma1 - gamma1_;
  const double step2 = gamma2 - gamma2_;
  const double squared_distance = square(step1) + square(step2);
  const double reach = parameters_.ramp_rate * duration;
  if (squared_distance <= square(reach)) {
    gamma1_ = gamma1;
    gamma2_ = gamma2;
  } else {
    const double share = reach / std::sqrt(squared_distance);
    gamma1_ += share * step1;
    gamma2_ += share * step2;
  }
}

}  // namespace cvg
