#include "ring_gyro/ros/message_checks.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>

#include "ring_gyro/common/formatted.h"
#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/signals/calibration_command.h"
#include "ring_gyro/signals/envelope.h"

namespace ring_gyro::bridge {
namespace {

constexpr double kLargest = 1e12;  // the identifier's limit: no square of it overflows later
constexpr std::uint64_t kLongestBlock = 3'600'000'000'000;  // [ns]
constexpr double kRounding = 1e-9;        // of the total of a drive's parts, relative
constexpr double kSmallestDrive = 1e-12;  // a smaller difference is also rounding [V]
constexpr std::size_t kMostOrders = 64;   // harmonics of a calibration

struct Field {
  const char* name;
  double value;
};

MessageFault impossible(const char* field, double value, const char* reason, const char* allowed) {
  return {cvg::Refusal::kImpossible, field, reason,
          cvg::formatted("%s = %.9g %s; allowed: %s", field, value, reason, allowed)};
}

/// Finds the field at fault when the sum of magnitudes is not below the limit.
MessageFault notFinite(const Field* fields, std::size_t size) {
  const Field* largest = fields;
  for (std::size_t i = 0; i < size; ++i) {
    const Field& field = fields[i];
    if (!std::isfinite(field.value)) {
      return {
          cvg::Refusal::kNotFinite, field.name, "is not finite",
          cvg::formatted("%s = %g is not finite; have its publisher send a number, or no message",
                         field.name, field.value)};
    }
    if (std::abs(field.value) > std::abs(largest->value)) largest = &field;
  }
  return {cvg::Refusal::kNotFinite, largest->name, "is absurdly large",
          cvg::formatted("%s = %g is absurdly large; allowed: below %g in SI units", largest->name,
                         largest->value, kLargest)};
}

/// Checks fields that must be finite and small enough to be squared.
template <std::size_t size>
inline MessageFault faultOfNumbers(const Field (&fields)[size]) {
  double sums[4] = {};  // in parallel: no addition waits for the previous one
  for (std::size_t i = 0; i < size; ++i) sums[i % 4] += std::abs(fields[i].value);
  if ((sums[0] + sums[1]) + (sums[2] + sums[3]) < kLargest) return {};  // false for NaN
  return notFinite(fields, size);
}

MessageFault faultOfDuration(std::uint64_t duration) {
  if (duration > 0 && duration <= kLongestBlock) return {};
  return impossible("duration", static_cast<double>(duration), "is no length of a block",
                    "(0, 3.6e12] [ns]");
}

std::string textOf(const cvg::Envelope& envelope) {
  return cvg::formatted("(%.9g%+.9gi, %.9g%+.9gi) V", envelope[0].real(), envelope[0].imag(),
                        envelope[1].real(), envelope[1].imag());
}

using Envelope = ring_gyro::Envelope;

/// Fault of the four parts and their total.
MessageFault faultOfDrive(const ring_gyro::ControlGains& m) {
  const auto difference = [&m](double Envelope::*part, double& size, bool& any_part) {
    const double sustain = m.sustain.*part, quadrature = m.quadrature.*part;
    const double steering = m.steering.*part, compensation = m.compensation.*part;
    size += std::abs(sustain) + std::abs(quadrature) + std::abs(steering) + std::abs(compensation);
    any_part = size > 0.0;
    return std::abs(sustain + quadrature + steering + compensation - m.drive.*part);
  };
  double size = 0.0;
  bool any_part = false;
  const double apart = difference(&Envelope::x_real, size, any_part) +
                       difference(&Envelope::x_imag, size, any_part) +
                       difference(&Envelope::y_real, size, any_part) +
                       difference(&Envelope::y_imag, size, any_part);
  if (!any_part || apart <= kRounding * size + kSmallestDrive) return {};
  const auto envelope = [](const Envelope& from) {
    return cvg::Envelope(std::complex<double>(from.x_real, from.x_imag),
                         std::complex<double>(from.y_real, from.y_imag));
  };
  const cvg::Envelope parts = envelope(m.sustain) + envelope(m.quadrature) + envelope(m.steering) +
                              envelope(m.compensation);
  return {cvg::Refusal::kContradiction, "drive", "is not the sum of its parts",
          "drive = " + textOf(envelope(m.drive)) + " is not the sum of its parts, " +
              textOf(parts) +
              "; send the total that was asked for with parts that add up to it, or with parts "
              "that are all zero"};
}

MessageFault faultOfOrders(const char* field, const std::vector<double>& coefficients) {
  if (coefficients.size() > kMostOrders) {
    return impossible(field, static_cast<double>(coefficients.size()), "orders are too many",
                      "64 at most");
  }
  for (const double coefficient : coefficients) {
    if (MessageFault fault = faultOfNumbers({{field, coefficient}})) return fault;
  }
  return {};
}

MessageFault faultOfEffect(std::uint64_t effective_sequence, std::uint64_t data_sequence) {
  if (effective_sequence > data_sequence) return {};
  return impossible("effective_sequence", static_cast<double>(effective_sequence),
                    "is not after data_sequence", "a block after the data that it came from");
}

MessageFault faultOf(const ring_gyro::Calibration& m) {
  if (MessageFault fault =
          faultOfNumbers({{"calibration.pickoff_cubic", m.pickoff_cubic},
                          {"calibration.drive_phase", m.drive_phase},
                          {"calibration.drive_mismatch", m.drive_mismatch},
                          {"calibration.drive_skew", m.drive_skew},
                          {"calibration.drive_rotation", m.drive_rotation},
                          {"calibration.phase_mismatch", m.phase_mismatch},
                          {"calibration.phase_skew", m.phase_skew},
                          {"calibration.rotation_phase", m.rotation_phase},
                          {"calibration.gamma1", m.gamma1},
                          {"calibration.gamma2", m.gamma2},
                          {"calibration.drift_constant", m.drift_constant},
                          {"calibration.angle_map_constant", m.angle_map_constant}})) {
    return fault;
  }
  if (MessageFault fault = faultOfOrders("calibration.drift_cosine", m.drift_cosine)) return fault;
  if (MessageFault fault = faultOfOrders("calibration.drift_sine", m.drift_sine)) return fault;
  if (MessageFault fault = faultOfOrders("calibration.angle_map_cosine", m.angle_map_cosine)) {
    return fault;
  }
  return faultOfOrders("calibration.angle_map_sine", m.angle_map_sine);
}

}  // namespace

MessageFault faultOf(const ring_gyro::DisplacementBlock& m) {
  if (MessageFault fault = faultOfNumbers({{"reference_phase", m.reference_phase},
                                           {"reference_frequency", m.reference_frequency}})) {
    return fault;
  }
  // Before the first drive there is no reference.
  if (m.reference_frequency < 0.0 || (m.driven != 0 && m.reference_frequency == 0.0)) {
    return impossible("reference_frequency", m.reference_frequency, "is not above zero",
                      "> 0 [rad/s] where a drive has acted");
  }
  if (m.saturated_samples > m.x.size() + m.y.size()) {
    return impossible("saturated_samples", static_cast<double>(m.saturated_samples),
                      "is more than there are samples", "as many as x and y hold");
  }
  if (m.clipped_drive_samples > m.x.size() + m.y.size()) {
    return impossible("clipped_drive_samples", static_cast<double>(m.clipped_drive_samples),
                      "is more than there are samples", "as many as x and y hold");
  }
  return faultOfDuration(m.duration);
}

MessageFault faultOf(const ring_gyro::DriveCommand& m) {
  if (MessageFault fault = faultOfNumbers({{"reference_phase", m.reference_phase},
                                           {"reference_frequency", m.reference_frequency},
                                           {"envelope.x_real", m.envelope.x_real},
                                           {"envelope.x_imag", m.envelope.x_imag},
                                           {"envelope.y_real", m.envelope.y_real},
                                           {"envelope.y_imag", m.envelope.y_imag},
                                           {"table_rate", m.table_rate}})) {
    return fault;
  }
  if (m.reference_frequency > 0.0) return {};
  return impossible("reference_frequency", m.reference_frequency, "is not above zero",
                    "> 0 [rad/s]");
}

MessageFault faultOf(const ring_gyro::OrbitalElements& m) {
  if (MessageFault fault = faultOfNumbers({{"group_delay", m.group_delay},
                                           {"a", m.a},
                                           {"b", m.b},
                                           {"theta", m.theta},
                                           {"phi", m.phi},
                                           {"theta_rate", m.theta_rate},
                                           {"angle", m.angle},
                                           {"angle_rate", m.angle_rate}})) {
    return fault;
  }
  if (m.group_delay < 0.0) {
    return impossible("group_delay", m.group_delay, "is negative", ">= 0 [s]");
  }
  return faultOfDuration(m.duration);
}

MessageFault faultOf(const ring_gyro::ControlGains& m) {
  if (MessageFault fault = faultOfNumbers({{"reference_frequency", m.reference_frequency},
                                           {"reference_phase", m.reference_phase},
                                           {"beta", m.beta},
                                           {"alpha", m.alpha},
                                           {"virtual_rate", m.virtual_rate},
                                           {"compensation_gain1", m.compensation_gain1},
                                           {"compensation_gain2", m.compensation_gain2},
                                           {"drive.x_real", m.drive.x_real},
                                           {"drive.x_imag", m.drive.x_imag},
                                           {"drive.y_real", m.drive.y_real},
                                           {"drive.y_imag", m.drive.y_imag},
                                           {"sustain.x_real", m.sustain.x_real},
                                           {"sustain.x_imag", m.sustain.x_imag},
                                           {"sustain.y_real", m.sustain.y_real},
                                           {"sustain.y_imag", m.sustain.y_imag},
                                           {"quadrature.x_real", m.quadrature.x_real},
                                           {"quadrature.x_imag", m.quadrature.x_imag},
                                           {"quadrature.y_real", m.quadrature.y_real},
                                           {"quadrature.y_imag", m.quadrature.y_imag},
                                           {"steering.x_real", m.steering.x_real},
                                           {"steering.x_imag", m.steering.x_imag},
                                           {"steering.y_real", m.steering.y_real},
                                           {"steering.y_imag", m.steering.y_imag},
                                           {"compensation.x_real", m.compensation.x_real},
                                           {"compensation.x_imag", m.compensation.x_imag},
                                           {"compensation.y_real", m.compensation.y_real},
                                           {"compensation.y_imag", m.compensation.y_imag}})) {
    return fault;
  }
  if (m.reference_frequency < 0.0) {
    return impossible("reference_frequency", m.reference_frequency, "is negative", ">= 0 [rad/s]");
  }
  if (MessageFault fault = faultOfDrive(m)) return fault;
  return faultOfDuration(m.duration);
}

MessageFault faultOf(const ring_gyro::ParameterEstimate& m) {
  const auto numbers = [](const char* field, const auto& values) -> MessageFault {
    for (const double value : values) {
      if (std::isfinite(value)) continue;
      const Field wrong{field, value};
      return notFinite(&wrong, 1);
    }
    return {};
  };
  if (MessageFault fault = numbers("value", m.value)) return fault;
  if (MessageFault fault = numbers("sigma", m.sigma)) return fault;
  if (MessageFault fault = numbers("covariance", m.covariance)) return fault;
  if (MessageFault fault = numbers("innovation", m.innovation)) return fault;
  if (MessageFault fault = numbers("innovation_covariance", m.innovation_covariance)) return fault;
  if (MessageFault fault =
          numbers("normalised_innovation_squared",
                  std::initializer_list<double>{m.normalised_innovation_squared})) {
    return fault;
  }
  if (MessageFault fault = faultOfNumbers({{"residual_gamma1", m.residual_gamma1},
                                           {"residual_gamma2", m.residual_gamma2},
                                           {"angle_covered", m.angle_covered}})) {
    return fault;
  }
  for (std::size_t i = 0; i < 7; ++i) {
    if (MessageFault fault = faultOfNumbers({{"value", m.value[i]}})) return fault;
    if (m.sigma[i] < 0.0) return impossible("sigma", m.sigma[i], "is negative", ">= 0");
    if (m.covariance[8 * i] < 0.0) {
      return impossible("covariance", m.covariance[8 * i], "has a negative variance", ">= 0");
    }
  }
  if (m.normalised_innovation_squared < 0.0) {
    return impossible("normalised_innovation_squared", m.normalised_innovation_squared,
                      "is negative", ">= 0");
  }
  if (m.angle_covered < 0.0) {
    return impossible("angle_covered", m.angle_covered, "is negative", ">= 0 [rad]");
  }
  if (m.first_sequence > m.last_sequence) {
    return impossible("first_sequence", static_cast<double>(m.first_sequence),
                      "is after last_sequence", "up to last_sequence");
  }
  return faultOfDuration(m.duration);
}

MessageFault faultOf(const ring_gyro::CompensationGains& m) {
  if (MessageFault fault = faultOfNumbers(
          {{"gain1", m.gain1}, {"gain2", m.gain2}, {"gamma1", m.gamma1}, {"gamma2", m.gamma2}})) {
    return fault;
  }
  if (m.state > ring_gyro::CompensationGains::LIMITED) {
    return impossible("state", m.state, "is no state", "0 to 4");
  }
  return faultOfEffect(m.effective_sequence, m.data_sequence);
}

MessageFault faultOf(const ring_gyro::CalibrationCommand& m) {
  if (MessageFault fault =
          faultOfNumbers({{"virtual_rate", m.virtual_rate},
                          {"table_rate", m.table_rate},
                          {"amplitude_modulation", m.amplitude_modulation},
                          {"amplitude_modulation_frequency", m.amplitude_modulation_frequency},
                          {"time_left", m.time_left}})) {
    return fault;
  }
  if (!(std::abs(m.amplitude_modulation) < 1.0)) {
    return impossible("amplitude_modulation", m.amplitude_modulation, "would stop the ring",
                      "(-1, 1)");
  }
  if (m.amplitude_modulation_frequency < 0.0) {
    return impossible("amplitude_modulation_frequency", m.amplitude_modulation_frequency,
                      "is negative", ">= 0 [Hz]");
  }
  if (MessageFault fault = faultOf(m.calibration)) return fault;
  return faultOfEffect(m.effective_sequence, m.data_sequence);
}

MessageFault faultOf(const ring_gyro::PlantTruth& m) {
  if (MessageFault fault = faultOfNumbers({{"envelope.x_real", m.envelope.x_real},
                                           {"envelope.x_imag", m.envelope.x_imag},
                                           {"envelope.y_real", m.envelope.y_real},
                                           {"envelope.y_imag", m.envelope.y_imag},
                                           {"a", m.a},
                                           {"b", m.b},
                                           {"theta", m.theta},
                                           {"phi", m.phi},
                                           {"rotation_rate", m.rotation_rate},
                                           {"rotation_angle", m.rotation_angle},
                                           {"natural_frequency", m.natural_frequency},
                                           {"quality_factor", m.quality_factor},
                                           {"gamma1", m.gamma1},
                                           {"gamma2", m.gamma2},
                                           {"mu1", m.mu1},
                                           {"mu2", m.mu2},
                                           {"drive_gain", m.drive_gain}})) {
    return fault;
  }
  if (!(m.natural_frequency > 0.0)) {
    return impossible("natural_frequency", m.natural_frequency, "is not above zero", "> 0 [Hz]");
  }
  if (!(m.quality_factor > 0.0)) {
    return impossible("quality_factor", m.quality_factor, "is not above zero", "> 0");
  }
  return faultOfDuration(m.duration);
}

MessageFault readChecked(const ring_gyro::OrbitalElements& message,
                         cvg::OrbitalElements& elements) {
  fromMessage(message, elements);
  MessageFault fault = faultOf(message);
  if (fault) {
    cvg::OrbitalElements refused;
    refused.stamp = elements.stamp;
    refused.status = elements.status;
    refused.status.refused = fault.kind;
    elements = refused;
  }
  return fault;
}

MessageFault readChecked(const ring_gyro::ControlGains& message, cvg::ControlGains& gains) {
  fromMessage(message, gains);
  MessageFault fault = faultOf(message);
  if (fault) {
    cvg::ControlGains refused;
    refused.stamp = gains.stamp;
    refused.status = gains.status;
    refused.status.refused = fault.kind;
    gains = refused;
  }
  return fault;
}

}  // namespace ring_gyro::bridge
