#include "ring_gyro/identification/extended_state.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "ring_gyro/common/angle.h"

namespace ring_gyro {
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

/// Derivative of z -> factor z as a real 2x2 matrix.
Eigen::Matrix2d realMatrix(Complex factor) {
  Eigen::Matrix2d result;
  result << factor.real(), -factor.imag(), factor.imag(), factor.real();
  return result;
}

}  // namespace

ExtendedState::ExtendedState(const ExtendedParameters& parameters)
    : names_{"re_x", "im_x", "re_y", "im_y", "gamma1", "gamma2", "mu1", "mu2", "drive_gain"},
      even_orders_(wholeOrders("even_harmonics", parameters.even_harmonics)),
      odd_orders_(wholeOrders("odd_harmonics", parameters.odd_harmonics)),
      nominal_decay_rate_(kPi * parameters.natural_frequency / parameters.quality_factor),
      nominal_frequency_(kTwoPi * parameters.natural_frequency) {
  if (!(parameters.natural_frequency > 0.0) || !(parameters.quality_factor > 0.0) ||
      !std::isfinite(nominal_decay_rate_)) {
    throw std::invalid_argument(
        "extended: natural_frequency and quality_factor of the device must be above zero");
  }
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
  if (parameters.drive_rotation) add(layout_.drive_rotation, {"drive_rotation"});
  if (parameters.drift_bias) add(layout_.drift_bias, {"drift_bias"});
  addHarmonics(layout_.even_harmonics, "drift", even_orders_);
  addHarmonics(layout_.odd_harmonics, "scale", odd_orders_);
  if (parameters.sense_matrix) add(layout_.sense_mismatch, {"sense_mismatch", "sense_skew"});
  if (parameters.pickoff_cubic) add(layout_.pickoff_cubic, {"pickoff_cubic"});
  if (parameters.estimate_rotation) add(layout_.rotation_rate, {"rotation_rate"});
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
  return layout_.decay_rate < 0 ? nominal_decay_rate_ : linear[layout_.decay_rate];
}

double ExtendedState::angularFrequency(const ExtendedVector& linear) const {
  return layout_.frequency < 0 ? nominal_frequency_ : kTwoPi * linear[layout_.frequency];
}

Complex ExtendedState::driveGain(const ExtendedVector& linear) const {
  return {linear[layout_.drive_gain],
          layout_.drive_phase < 0 ? 0.0 : linear[layout_.drive_phase]};
}

// Linear coordinates that differ from the physical ones: decay rate times gamma; re and im of
// ks e^{-ip} in the places of ks and p; re and im of ks e^{-ip} (e + i q) in those of e and q; ks
// times the rotation of the drive.
ExtendedVector ExtendedState::physical(const ExtendedVector& linear) const {
  ExtendedVector result = linear;
  const double decay = decayRate(linear);
  result.segment<2>(layout_.gamma) /= decay;
  const Complex gain = driveGain(linear);
  if (layout_.drive_phase >= 0) {
    result[layout_.drive_gain] = std::abs(gain);
    result[layout_.drive_phase] = -std::arg(gain);
    for (int k = 0; k < 2; ++k) {
      const int at = layout_.mismatch + k;
      const Complex mismatch = Complex(linear[at], linear[at + 2]) / gain;
      result[at] = mismatch.real();
      result[at + 2] = mismatch.imag();
    }
  }
  if (layout_.drive_rotation >= 0) result[layout_.drive_rotation] /= std::abs(gain);
  return result;
}

ExtendedVector ExtendedState::linear(const ExtendedVector& physical) const {
  ExtendedVector result = physical;
  const double decay = layout_.decay_rate < 0 ? nominal_decay_rate_ : physical[layout_.decay_rate];
  result.segment<2>(layout_.gamma) *= decay;
  const double size = physical[layout_.drive_gain];
  if (layout_.drive_phase >= 0) {
    const Complex gain = std::polar(size, -physical[layout_.drive_phase]);
    result[layout_.drive_gain] = gain.real();
    result[layout_.drive_phase] = gain.imag();
    for (int k = 0; k < 2; ++k) {
      const int at = layout_.mismatch + k;
      const Complex entry = gain * Complex(physical[at], physical[at + 2]);
      result[at] = entry.real();
      result[at + 2] = entry.imag();
    }
  }
  if (layout_.drive_rotation >= 0) result[layout_.drive_rotation] *= size;
  return result;
}

ExtendedMatrix ExtendedState::linearByPhysical(const ExtendedVector& physical) const {
  ExtendedMatrix result = ExtendedMatrix::Identity(size(), size());
  const int decay_at = layout_.decay_rate;
  const double decay = decay_at < 0 ? nominal_decay_rate_ : physical[decay_at];
  for (int k = 0; k < 2; ++k) {
    result(layout_.gamma + k, layout_.gamma + k) = decay;
    if (decay_at >= 0) result(layout_.gamma + k, decay_at) = physical[layout_.gamma + k];
  }
  const int gain_at = layout_.drive_gain;
  const double size_of_gain = physical[gain_at];
  if (layout_.drive_phase >= 0) {
    const int phase_at = layout_.drive_phase;
    const Complex direction = std::polar(1.0, -physical[phase_at]);
    const Complex gain = size_of_gain * direction;
    const Complex by_phase(gain.imag(), -gain.real());  // -i gain
    const auto setRows = [&result](int re, int im, int column, Complex value) {
      result(re, column) = value.real();
      result(im, column) = value.imag();
    };
    setRows(gain_at, phase_at, gain_at, direction);
    setRows(gain_at, phase_at, phase_at, by_phase);
    for (int k = 0; k < 2; ++k) {
      const int at = layout_.mismatch + k;
      const Complex mismatch(physical[at], physical[at + 2]);
      setRows(at, at + 2, at, gain);
      setRows(at, at + 2, at + 2, Complex(-gain.imag(), gain.real()));
      setRows(at, at + 2, gain_at, direction * mismatch);
      setRows(at, at + 2, phase_at, by_phase * mismatch);
    }
  }
  if (layout_.drive_rotation >= 0) {
    result(layout_.drive_rotation, layout_.drive_rotation) = size_of_gain;
    result(layout_.drive_rotation, gain_at) = physical[layout_.drive_rotation];
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
  const Complex gain = driveGain(linear);
  const double size_of_gain = std::abs(gain);
  const Complex direction = gain / size_of_gain;
  const int phase_at = layout_.drive_phase;
  if (phase_at >= 0) {
    result(gain_at, gain_at) = direction.real();
    result(gain_at, phase_at) = direction.imag();
    result(phase_at, gain_at) = direction.imag() / size_of_gain;
    result(phase_at, phase_at) = -direction.real() / size_of_gain;
    for (int k = 0; k < 2; ++k) {
      const int at = layout_.mismatch + k;
      const Complex entry(linear[at], linear[at + 2]);
      const Eigen::Matrix2d by_entry = realMatrix(1.0 / gain);
      const Eigen::Matrix2d by_gain = realMatrix(-entry / (gain * gain));
      for (int row = 0; row < 2; ++row) {
        for (int column = 0; column < 2; ++column) {
          result(at + 2 * row, at + 2 * column) = by_entry(row, column);
          result(at + 2 * row, column == 0 ? gain_at : phase_at) = by_gain(row, column);
        }
      }
    }
  }
  if (layout_.drive_rotation >= 0) {
    const int at = layout_.drive_rotation;
    const double slope = -linear[at] / (size_of_gain * size_of_gain);
    result(at, at) = 1.0 / size_of_gain;
    result(at, gain_at) = slope * direction.real();
    if (phase_at >= 0) result(at, phase_at) = slope * direction.imag();
  }
  return result;
}

}  // namespace ring_gyro
