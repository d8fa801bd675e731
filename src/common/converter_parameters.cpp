#include "ring_gyro/common/converter_parameters.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace cvg {

std::int64_t ConverterParameters::blockDurationNanoseconds() const {
  const double exact = 1e9 * blockDuration();
  const double rounded = std::round(exact);
  // Also refuses NaN and infinity, which invalid parameters give.
  if (!(std::abs(exact - rounded) <= 1e-6) || !(rounded >= 1.0)) {
    throw std::invalid_argument(
        "converter: block_samples / sample_rate = " + std::to_string(exact) +
        " ns must be a whole number of nanoseconds; change block_samples or sample_rate");
  }
  return static_cast<std::int64_t>(rounded);
}

std::int64_t ConverterParameters::wholeBlocks(double period, const std::string& name) const {
  const double blocks = period / blockDuration();
  const double whole = std::round(blocks);
  if (!(whole >= 1.0) || !(std::abs(blocks - whole) <= 1e-6)) {
    std::ostringstream fault;
    fault << name << " = " << period << " s must be a whole number of blocks of " << blockDuration()
          << " s";
    throw std::invalid_argument(fault.str());
  }
  return static_cast<std::int64_t>(whole);
}

void ConverterParameters::declare(ParameterTable& table) {
  table
      .number("sample_rate", sample_rate, "Hz", Range::between(1e3, 100e6),
              "rate of the converters that read the displacements and hold the drive")
      .integer("block_samples", block_samples, Range::between(2, 100000),
               "samples in a block; one block is one step of the control loops");
}

}  // namespace cvg
