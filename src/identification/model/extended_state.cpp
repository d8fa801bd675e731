#include "ring_gyro/identification/model/extended_state.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "ring_gyro/common/angle.h"

namespace cvg {
namespace {

using Complex = std::complex<double>;

std::vector<int> wholeOrders(const char* key, const std::vector<double>& orders) {
  std::vector<int> result;
  for (double order : orders) {
    const int whole = static_cast<int>(std::lround(order));
    if (!(order >= 1.0) || order != whole) {
      throw std::invalid_argument(std::string("extended: ") + key + " has the order " +
                                  std::to_string(order) + "; orders are whole numbers from 1 on");
    }
    if (std::find(result.begin(), result.end(), whole) != result.end()) {
      throw std::invalid_argument(std::string("extended: ") + key + " has the order " +
                                  std::to_string(whole) + " twice");
    }
    result.push_back(whole);
  }
  return result;
}

}  // namespace

ExtendedState::ExtendedState(const DeviceKnowledge& device, const ExtendedParameters& parameters)
    : names_{"re_x", "im_x", "re_y", "im_y", "gamma1", "gamma2", "mu1", "mu2", "drive_gain"},
      even_orders_(wholeOrders("even_harmonics", parameters.even_harmonics)),
      odd_orders_(wholeOrders("odd_harmonics", parameters.odd_harmonics)),
      device_(device) {
  device.requireResonance("extended");
  if (parameters.drift_bias && parameters.estimate_rotation) {
    throw std::invalid_argument(
        "extended: drift_bias and estimate_rotation both turn the pattern alike at every angle and "
        "cannot be told apart; switch one off");
  }
  const auto add = [this](int& place, std::initializer_list<const char*> names) {
    place = static_cast<int>(names_.size());
    names_.insert(names_.end(), names.begin(), names.end());
  };
  const auto addHarmonics = [this](int& place, const std::string& name,
                                   const std::vector<int>& orders) {
    if (orders.empty()) return;
    place = static_cast<int>(names_.size());
    for (int order : orders) {
      names_.push_back(name + "_cos" + std::to_string(order));
      names_.push_back(name + "_sin" + std::to_string(order));
    }
  };
  if (parameters.quality) add(layout_.decay_rate, {"decay_rate"});
  if (parameters.frequency) add(layout_.frequency, {"natural_frequency"});
  if (parameters.drive_matrix) {
    add(layout_.drive_phase, {"drive_phase"});
    add(layout_.mismatch, {"drive_mismatch", "drive_skew", "phase_mismatch", "phase_skew"});
  }
  if (parameters.drive_rotation) {
    add(layout_.drive_rotation, {"drive_rotation", "drive_rotation_phase"});
  }
  if (parameters.drift_bias) add(layout_.drift_bias, {"drift_bias", "quadrature_bias"});
  addHarmonics(layout_.even_harmonics, "drift", even_orders_);
  addHarmonics(layout_.odd_harmonics, "scale", odd_orders_);
  if (parameters.sense_matrix) {
    add(layout_.sense_mismatch,
        {"sense_mismatch", "sense_skew", "sense_phase_mismatch", "sense_phase_skew"});
  }
  if (parameters.rotation_scale) add(layout_.rotation_scale, {"rotation_scale"});
  if (parameters.pickoff_cubic) add(layout_.pickoff_cubic, {"pickoff_cubic"});
  if (parameters.estimate_rotation) add(layout_.rotation_rate, {"rotation_rate"});
  if (layout_.mismatch >= 0) {
    entries_.push_back({layout_.mismatch, layout_.mismatch + 2});
    entries_.push_back({layout_.mismatch + 1, layout_.mismatch + 3});
  }
  if (layout_.drive_rotation >= 0) {
    entries_.push_back({layout_.drive_rotation, layout_.drive_rotation + 1});
  }
  if (size() > kMostExtendedStates) {
    throw std::invalid_argument("extended: " + std::to_string(size()) + " states, at most " +
                                std::to_string(kMostExtendedStates) + "; list fewer harmonics");
  }
}

std::optional<Eigen::Index> ExtendedState::find(const std::string& name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found == names_.end()) return std::nullopt;
  return static_cast<Eigen::Index>(found - names_.begin());
}

double ExtendedState::decayRate(const ExtendedVector& linear) const {
  return layout_.decay_rate < 0 ? device_.decayRate() : linear[layout_.decay_rate];
}

double ExtendedState::angularFrequency(const ExtendedVector& linear) const {
  return layout_.frequency < 0 ? device_.angularFrequency() : kTwoPi * linear[layout_.frequency];
}

Complex ExtendedState::driveGain(const ExtendedVector& linear) const {
  return {linear[layout_.drive_gain], layout_.drive_phase < 0 ? 0.0 : linear[layout_.drive_phase]};
}

// Linear coordinates that differ from the physical ones: decay rate times gamma in place of gamma;
// re and im of ks e^{-ip} in place of ks and p; re and im of ks e^{-ip} times each entry of the
// drive matrix in place of the entry.
ExtendedVector ExtendedState::physical(const ExtendedVector& linear) const {
  ExtendedVector result = linear;
  result.segment<2>(layout_.gamma) /= decayRate(linear);
  const Complex gain = driveGain(linear);
  if (layout_.drive_phase >= 0) {
    result[layout_.drive_gain] = std::abs(gain);
    result[layout_.drive_phase] = -std::arg(gain);
  }
  for (const Entry& entry : entries_) {
    const Complex value = Complex(linear[entry.real], linear[entry.imaginary]) / gain;
    result[entry.real] = value.real();
    result[entry.imaginary] = value.imag();
  }
  return result;
}

ExtendedVector ExtendedState::linear(const ExtendedVector& physical) const {
  ExtendedVector result = physical;
  result.segment<2>(layout_.gamma) *=
      layout_.decay_rate < 0 ? device_.decayRate() : physical[layout_.decay_rate];
  const double phase = layout_.drive_phase < 0 ? 0.0 : physical[layout_.drive_phase];
  const Complex gain = std::polar(physical[layout_.drive_gain], -phase);
  if (layout_.drive_phase >= 0) {
    result[layout_.drive_gain] = gain.real();
    result[layout_.drive_phase] = gain.imag();
  }
  for (const Entry& entry : entries_) {
    const Complex value = gain * Complex(physical[entry.real], physical[entry.imaginary]);
    result[entry.real] = value.real();
    result[entry.imaginary] = value.imag();
  }
  return result;
}

ExtendedMatrix ExtendedState::linearByPhysical(const ExtendedVector& physical) const {
  ExtendedMatrix result = ExtendedMatrix::Identity(size(), size());
  const int decay_at = layout_.decay_rate;
  for (int k = 0; k < 2; ++k) {
    const int at = layout_.gamma + k;
    result(at, at) = decay_at < 0 ? device_.decayRate() : physical[decay_at];
    if (decay_at >= 0) result(at, decay_at) = physical[at];
  }
  const int gain_at = layout_.drive_gain;
  const int phase_at = layout_.drive_phase;
  const Complex direction = std::polar(1.0, phase_at < 0 ? 0.0 : -physical[phase_at]);
  const Complex gain = physical[gain_at] * direction;
  const Complex by_phase(gain.imag(), -gain.real());  // -i gain
  const auto setRows = [&result](int real, int imaginary, int column, Complex value) {
    result(real, column) = value.real();
    result(imaginary, column) = value.imag();
  };
  if (phase_at >= 0) {
    setRows(gain_at, phase_at, gain_at, direction);
    setRows(gain_at, phase_at, phase_at, by_phase);
  }
  for (const Entry& entry : entries_) {
    const Complex value(physical[entry.real], physical[entry.imaginary]);
    setRows(entry.real, entry.imaginary, entry.real, gain);
    setRows(entry.real, entry.imaginary, entry.imaginary, Complex(-gain.imag(), gain.real()));
    setRows(entry.real, entry.imaginary, gain_at, direction * value);
    if (phase_at >= 0) setRows(entry.real, entry.imaginary, phase_at, by_phase * value);
  }
  return result;
}

ExtendedMatrix ExtendedState::physicalByLinear(const ExtendedVector& linear) const {
  ExtendedMatrix result = ExtendedMatrix::Identity(size(), size());
  const int decay_at = layout_.decay_rate;
  const double decay = decayRate(linear);
  for (int k = 0; k < 2; ++k) {
    const int at = layout_.gamma + k;
    result(at, at) = 1.0 / decay;
    if (decay_at >= 0) result(at, decay_at) = -linear[at] / (decay * decay);
  }
  const int gain_at = layout_.drive_gain;
  const int phase_at = layout_.drive_phase;
  const Complex gain = driveGain(linear);
  const double size_of_gain = std::abs(gain);
  if (phase_at >= 0) {
    const Complex direction = gain / size_of_gain;
    result(gain_at, gain_at) = direction.real();
    result(gain_at, phase_at) = direction.imag();
    result(phase_at, gain_at) = direction.imag() / size_of_gain;
    result(phase_at, phase_at) = -direction.real() / size_of_gain;
  }
  const auto setRows = [&result](const Entry& entry, int column, Complex value) {
    result(entry.real, column) = value.real();
    result(entry.imaginary, column) = value.imag();
  };
  for (const Entry& entry : entries_) {
    const Complex by_gain = -Complex(linear[entry.real], linear[entry.imaginary]) / (gain * gain);
    setRows(entry, entry.real, 1.0 / gain);
    setRows(entry, entry.imaginary, Complex(0.0, 1.0) / gain);
    setRows(entry, gain_at, by_gain);
    if (phase_at >= 0) setRows(entry, phase_at, Complex(0.0, 1.0) * by_gain);
  }
  return result;
}

}  // namespace cvg
