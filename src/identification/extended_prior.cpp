#include "ring_gyro/identification/extended_prior.h"

#include <cmath>
#include <complex>

#include "ring_gyro/common/angle.h"

namespace ring_gyro {

void FirstLookSum::add(const Orbit& orbit, const Eigen::Vector2cd& drive,
                       double reference_frequency) {
  const std::complex<double> along =
      std::cos(orbit.theta) * drive.x() + std::sin(orbit.theta) * drive.y();
  amplitude_ += orbit.a;
  frequency_ += reference_frequency;
  drive_ += (std::polar(1.0, -orbit.phi) * along).imag();
  if (blocks_ == 0) first_phi_ = orbit.phi;
  last_phi_ = orbit.phi;
  ++blocks_;
}

FirstLook FirstLookSum::look(double duration, double decay_rate) const {
  const double frequency = frequency_ / blocks_;
  // phi' = w0 - w, but for mu.
  const double slip = blocks_ > 1 ? (last_phi_ - first_phi_) / ((blocks_ - 1) * duration) : 0.0;
  return {2.0 * frequency * decay_rate * amplitude_ / drive_, (frequency + slip) / kTwoPi};
}

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
  if (at.decay_rate >= 0) value[at.decay_rate] = state.nominalDecayRate();
  if (at.frequency >= 0) value[at.frequency] = look.frequency;
  if (at.pickoff_cubic >= 0) value[at.pickoff_cubic] = parameters.initial_cubic;
  return value;
}

ExtendedVector priorSigma(const ExtendedState& state, const ExtendedParameters& p,
                          const ExtendedVector& value) {
  const ExtendedState::Layout& at = state.layout();
  ExtendedVector sigma = ExtendedVector::Zero(state.size());
  sigma.segment<2>(at.gamma).setConstant(p.initial_gamma_sigma);
  sigma.segment<2>(at.mu).setConstant(p.initial_mu_sigma);
  sigma[at.drive_gain] = p.initial_drive_gain_sigma * value[at.drive_gain];
  if (at.decay_rate >= 0) sigma[at.decay_rate] = p.initial_quality_sigma * value[at.decay_rate];
  // f0 is set from where the phase-locked loop is, which mu moves by half of itself.
  if (at.frequency >= 0) sigma[at.frequency] = p.initial_mu_sigma * p.natural_frequency;
  if (at.drive_phase >= 0) sigma[at.drive_phase] = p.initial_drive_phase_sigma;
  if (at.mismatch >= 0) {
    sigma.segment<2>(at.mismatch).setConstant(p.initial_mismatch_sigma);
    sigma.segment<2>(at.mismatch + 2).setConstant(p.initial_drive_phase_sigma);
  }
  if (at.drive_rotation >= 0) {
    sigma[at.drive_rotation] = p.initial_mismatch_sigma;
    sigma[at.drive_rotation + 1] = p.initial_drive_phase_sigma;
  }
  if (at.drift_bias >= 0) sigma.segment<2>(at.drift_bias).setConstant(p.initial_drift_sigma);
  const auto harmonics = [&sigma](int first, std::size_t orders, double value_of_sigma) {
    if (first < 0) return;
    sigma.segment(first, 2 * static_cast<Eigen::Index>(orders)).setConstant(value_of_sigma);
  };
  harmonics(at.even_harmonics, state.evenOrders().size(), p.initial_drift_sigma);
  harmonics(at.odd_harmonics, state.oddOrders().size(), p.initial_scale_sigma);
  if (at.sense_mismatch >= 0) {
    sigma.segment<2>(at.sense_mismatch).setConstant(p.initial_mismatch_sigma);
    sigma.segment<2>(at.sense_mismatch + 2).setConstant(p.initial_drive_phase_sigma);
  }
  if (at.rotation_scale >= 0) sigma[at.rotation_scale] = p.initial_scale_sigma;
  if (at.pickoff_cubic >= 0) sigma[at.pickoff_cubic] = p.initial_cubic_sigma;
  if (at.rotation_rate >= 0) sigma[at.rotation_rate] = p.initial_rotation_sigma;
  return sigma;
}

ExtendedVector parameterWalk(const ExtendedState& state, const ExtendedParameters& p,
                             const ExtendedVector& value) {
  const ExtendedState::Layout& at = state.layout();
  ExtendedVector walk = ExtendedVector::Zero(state.size());
  walk.segment<2>(at.gamma).setConstant(p.gamma_walk);
  walk.segment<2>(at.mu).setConstant(p.mu_walk);
  walk[at.drive_gain] = p.drive_gain_walk * value[at.drive_gain];
  if (at.decay_rate >= 0) walk[at.decay_rate] = p.quality_walk * value[at.decay_rate];
  if (at.frequency >= 0) walk[at.frequency] = p.frequency_walk;
  if (at.drift_bias >= 0) walk.segment<2>(at.drift_bias).setConstant(p.drift_walk);
  if (at.even_harmonics >= 0) {
    walk.segment(at.even_harmonics, 2 * static_cast<Eigen::Index>(state.evenOrders().size()))
        .setConstant(p.drift_walk);
  }
  if (at.rotation_rate >= 0) walk[at.rotation_rate] = p.rotation_walk;
  return walk;
}

}  // namespace ring_gyro
