#include "ring_gyro/identification/filter/extended_prior.h"

namespace cvg {
namespace {

/// For each state: prior sigma about its start, and random walk.
struct Spread {
  ExtendedVector prior;
  ExtendedVector walk;
};

Spread spreadOf(const ExtendedState& state, const ExtendedParameters& p,
                const ExtendedVector& value) {
  const ExtendedState::Layout& at = state.layout();
  Spread spread{ExtendedVector::Zero(state.size()), ExtendedVector::Zero(state.size())};
  const auto set = [&spread](int first, Eigen::Index count, double prior, double walk) {
    if (first < 0) return;
    spread.prior.segment(first, count).setConstant(prior);
    spread.walk.segment(first, count).setConstant(walk);
  };
  const auto setRelative = [&](int index, double prior, double walk) {
    if (index >= 0) set(index, 1, prior * value[index], walk * value[index]);
  };
  // Of gains, then of phases; neither has a random walk.
  const auto setMismatch = [&](int first, int count) {
    if (first < 0) return;
    set(first, count, p.initial_mismatch_sigma, 0.0);
    set(first + count, count, p.initial_drive_phase_sigma, 0.0);
  };
  set(at.gamma, 2, p.initial_gamma_sigma, p.gamma_walk);
  set(at.mu, 2, p.initial_mu_sigma, p.mu_walk);
  setRelative(at.drive_gain, p.initial_drive_gain_sigma, p.drive_gain_walk);
  setRelative(at.decay_rate, p.initial_quality_sigma, p.quality_walk);
  // f0 starts from the frequency of the phase-locked loop, which mu shifts by mu / 2, relative.
  set(at.frequency, 1, p.initial_mu_sigma * state.device().natural_frequency, p.frequency_walk);
  set(at.drive_phase, 1, p.initial_drive_phase_sigma, 0.0);
  setMismatch(at.mismatch, 2);
  setMismatch(at.drive_rotation, 1);
  setMismatch(at.sense_mismatch, 2);
  set(at.drift_bias, 2, p.initial_drift_sigma, p.drift_walk);
  set(at.even_harmonics, 2 * static_cast<Eigen::Index>(state.evenOrders().size()),
      p.initial_drift_sigma, p.drift_walk);
  set(at.odd_harmonics, 2 * static_cast<Eigen::Index>(state.oddOrders().size()),
      p.initial_scale_sigma, 0.0);
  set(at.rotation_scale, 1, p.initial_scale_sigma, 0.0);
  set(at.pickoff_cubic, 1, p.initial_cubic_sigma, 0.0);
  set(at.rotation_rate, 1, p.initial_rotation_sigma, p.rotation_walk);
  return spread;
}

}  // namespace

ExtendedVector startValue(const ExtendedState& state, const ExtendedParameters& parameters,
                          const FirstLook& look) {
  const ExtendedState::Layout& at = state.layout();
  ExtendedVector value = ExtendedVector::Zero(state.size());
  value[at.gamma] = parameters.initial_gamma1;
  value[at.gamma + 1] = parameters.initial_gamma2;
  value[at.mu] = parameters.initial_mu1;
  value[at.mu + 1] = parameters.initial_mu2;
  value[at.drive_gain] =
      parameters.initial_drive_gain > 0.0 ? parameters.initial_drive_gain : look.drive_gain;
  if (at.decay_rate >= 0) value[at.decay_rate] = state.device().decayRate();
  if (at.frequency >= 0) value[at.frequency] = look.frequency;
  if (at.pickoff_cubic >= 0) value[at.pickoff_cubic] = parameters.initial_cubic;
  return value;
}

ExtendedVector priorSigma(const ExtendedState& state, const ExtendedParameters& parameters,
                          const ExtendedVector& value) {
  return spreadOf(state, parameters, value).prior;
}

ExtendedVector parameterWalk(const ExtendedState& state, const ExtendedParameters& parameters,
                             const ExtendedVector& value) {
  return spreadOf(state, parameters, value).walk;
}

}  // namespace cvg
