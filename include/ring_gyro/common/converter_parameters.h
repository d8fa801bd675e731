#pragma once

#include <cstdint>
#include <string>

#include "ring_gyro/common/parameter_table.h"

namespace cvg {

/// Clock of the converters and length of the blocks of samples.
struct ConverterParameters {
  double sample_rate = 200e3;        ///< [Hz]
  std::int64_t block_samples = 200;  ///< one block is one step of the loops

  double samplePeriod() const { return 1.0 / sample_rate; }  ///< [s]
  double blockDuration() const {                             ///< [s]
    return static_cast<double>(block_samples) / sample_rate;
  }
  /// [ns]; throws std::invalid_argument when the block is not a whole number of nanoseconds.
  std::int64_t blockDurationNanoseconds() const;
  /// Blocks in a period [s]. Throws std::invalid_argument, with `name`, unless this is a whole
  /// number of at least 1.
  std::int64_t wholeBlocks(double period, const std::string& name) const;

  void declare(ParameterTable& table);
};

}  // namespace cvg
