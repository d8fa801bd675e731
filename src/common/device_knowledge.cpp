#include "ring_gyro/common/device_knowledge.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace cvg {

void DeviceKnowledge::requireResonance(const char* user) const {
  const auto require = [user](const char* key, double value) {
    if (value > 0.0 && std::isfinite(value)) return;
    throw std::invalid_argument(std::string(user) + ": device/" + key + " = " +
                                std::to_string(value) + " must be finite and above zero");
  };
  require("natural_frequency", natural_frequency);
  require("quality_factor", quality_factor);
}

void DeviceKnowledge::declare(ParameterTable& table) {
  // No ring has a Bryan factor above 1. But the value measured on a rate table also contains the
  // scale error of the table and the second order of the pick-off's errors, and the result of a
  // calibration run must be readable.
  constexpr double kLargestMeasuredGain = 1.1;
  table
      .requiredNumber("natural_frequency", natural_frequency, "Hz", Range::between(1.0, 10e6),
                      "f0, start of the NCO and frequency of the averaged model")
      .requiredNumber("quality_factor", quality_factor, "1", Range::between(10.0, 1e9),
                      "Q, for the loop gains and as the scale of identified damping and ks")
      .requiredNumber("drive_gain", drive_gain, "1/s^2", Range::above(0.0),
                      "ks as the loops assume it; the identifier finds its own")
      .number("angular_gain", angular_gain, "1", Range::between(0.01, kLargestMeasuredGain),
              "k, the Bryan factor; converts the pattern rate to the reported rate of the case");
}

}  // namespace cvg
