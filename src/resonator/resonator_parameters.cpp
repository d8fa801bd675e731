#include "ring_gyro/resonator/resonator_parameters.h"

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace cvg {

double ResonatorParameters::driveGain() const {
  const std::array<std::pair<const char*, double>, 5> capacitors = {
      {{"bias_voltage", bias_voltage},
       {"electrode_gap", electrode_gap},
       {"electrode_capacitance", electrode_capacitance},
       {"feedback_capacitance", feedback_capacitance},
       {"modal_mass", modal_mass}}};
  std::string missing;
  std::size_t given = 0;
  for (const auto& [name, value] : capacitors) {
    if (value > 0.0) {
      ++given;
    } else {
      missing += std::string(missing.empty() ? "" : ", ") + name;
    }
  }
  if (given == 0) {
    if (drive_gain > 0.0) return drive_gain;
    throw std::invalid_argument("resonator: drive_gain is 0; give drive_gain > 0, or all of " +
                                missing);
  }
  if (drive_gain > 0.0) {
    throw std::invalid_argument(
        "resonator: drive_gain and the capacitors are both given; remove one of them");
  }
  if (given < capacitors.size()) {
    throw std::invalid_argument("resonator: drive_gain from the capacitors also needs " + missing);
  }
  const double conduction_gain = bias_voltage * electrode_capacitance / electrode_gap;
  return conduction_gain * conduction_gain / (modal_mass * feedback_capacitance);
}

ResonatorParameters ResonatorParameters::tuned() const {
  const auto softening = [&](double volt) { return tuning_gain * volt * volt; };
  const double along = softening(tuning_voltage_0) - softening(tuning_voltage_90);
  const double across = softening(tuning_voltage_45) - softening(tuning_voltage_135);
  const double both = softening(tuning_voltage_0) + softening(tuning_voltage_90) +
                      softening(tuning_voltage_45) + softening(tuning_voltage_135);
  const double stiffness = 1.0 - 0.5 * both;  // of both modes, relative to w0^2
  if (stiffness <= 0.0) {
    throw std::invalid_argument(
        "resonator: the tuning voltages take more stiffness than there is; lower tuning_voltage_* "
        "or "
        "tuning_gain");
  }
  ResonatorParameters ring = *this;
  ring.natural_frequency = natural_frequency * std::sqrt(stiffness);
  ring.quality_factor = quality_factor * std::sqrt(stiffness);
  ring.mu1 = (mu1 - 0.5 * along) / stiffness;
  ring.mu2 = (mu2 - 0.5 * across) / stiffness;
  ring.tuning_voltage_0 = ring.tuning_voltage_90 = 0.0;
  ring.tuning_voltage_45 = ring.tuning_voltage_135 = 0.0;
  return ring;
}

void ResonatorParameters::declare(ParameterTable& table) {
  table
      .requiredNumber("natural_frequency", natural_frequency, "Hz", Range::between(100.0, 1e7),
                      "f0 of the ring without mismatch")
      .requiredNumber("quality_factor", quality_factor, "1", Range::between(50.0, 1e9),
                      "Q of the ring without mismatch")
      .number("gamma1", gamma1, "1", Range::between(-0.9, 0.9), "damping mismatch along the axes")
      .number("gamma2", gamma2, "1", Range::between(-0.9, 0.9), "damping mismatch across the axes")
      .number("mu1", mu1, "1", Range::between(-1e-2, 1e-2), "stiffness mismatch along the axes")
      .number("mu2", mu2, "1", Range::between(-1e-2, 1e-2), "stiffness mismatch across the axes")
      .number("drive_gain", drive_gain, "1/s^2", Range::atLeast(0.0),
              "ks, sensed acceleration per drive volt; 0: from the capacitors")
      .number("angular_gain", angular_gain, "1", Range::between(0.0, 1.0),
              "k, Bryan factor: precession per rotation")
      .number("cubic_stiffness", cubic_stiffness, "1/V^2", Range::between(-0.1, 0.1),
              "relative increase of the stiffness per squared displacement")
      .number("thermal_noise_density", thermal_noise_density, "V/sqrt(Hz)", Range::atLeast(0.0),
              "thermo-mechanical force noise, referred to the drive, one-sided")
      .number("bias_voltage", bias_voltage, "V", Range::atLeast(0.0),
              "DC bias of the electrodes, (7)-(9)")
      .number("electrode_gap", electrode_gap, "m", Range::atLeast(0.0), "capacitor gap")
      .number("electrode_capacitance", electrode_capacitance, "F", Range::atLeast(0.0),
              "capacitance at rest")
      .number("feedback_capacitance", feedback_capacitance, "F", Range::atLeast(0.0),
              "of the charge amplifier")
      .number("modal_mass", modal_mass, "kg", Range::atLeast(0.0), "mass of one mode")
      .number("tuning_gain", tuning_gain, "1/V^2", Range::between(0.0, 1e-2),
              "softening of a tuning electrode, relative to w0^2")
      .number("tuning_voltage_0", tuning_voltage_0, "V", Range::between(-100.0, 100.0),
              "of the tuning electrode along x, lowers mu1")
      .number("tuning_voltage_90", tuning_voltage_90, "V", Range::between(-100.0, 100.0),
              "of the tuning electrode along y, raises mu1")
      .number("tuning_voltage_45", tuning_voltage_45, "V", Range::between(-100.0, 100.0),
              "of the tuning electrode between x and y, lowers mu2")
      .number("tuning_voltage_135", tuning_voltage_135, "V", Range::between(-100.0, 100.0),
              "of the tuning electrode between y and -x, raises mu2")
      .number("temperature_rate", temperature_rate, "K/s", Range::between(-10.0, 10.0),
              "drift of the temperature since the start")
      .number("frequency_temperature_coefficient", frequency_temperature_coefficient, "1/K",
              Range::between(-1e-2, 1e-2), "relative change of f0")
      .number("quality_temperature_coefficient", quality_temperature_coefficient, "1/K",
              Range::between(-0.1, 0.1), "relative change of Q")
      .number("gamma_temperature_coefficient", gamma_temperature_coefficient, "1/K",
              Range::between(-0.1, 0.1), "relative change of gamma1 and gamma2");
}

}  // namespace cvg
