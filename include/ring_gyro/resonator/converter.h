#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "ring_gyro/common/vector_kernels.h"

namespace cvg {

/// A converter with 2^bits levels over +-range, or an ideal one (0 bits).
class Converter {
 public:
  Converter(std::int64_t bits, double range)
      : ideal_(bits == 0),
        step_(2.0 * range / std::ldexp(1.0, static_cast<int>(bits))),
        lowest_(-range),
        highest_(range - step_) {}

  bool ideal() const { return ideal_; }

  /// Rounds each of `count` values [V] (whole lanes of the kernels) to its nearest level and gives
  /// the number of values that were outside the range.
  std::size_t convert(double* values, std::size_t count) const {
    return ideal_ ? 0 : quantise(step_, lowest_, highest_, count, values);
  }

 private:
  bool ideal_;
  double step_;
  double lowest_;
  double highest_;
};

}  // namespace cvg
