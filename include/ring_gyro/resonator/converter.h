#pragma once

#include <cmath>
#include <cstdint>

namespace ring_gyro {

/// A converter with 2^bits levels over +-range, or an ideal one (0 bits).
class Converter {
 public:
  Converter(std::int64_t bits, double range)
      : ideal_(bits == 0),
        step_(2.0 * range / std::ldexp(1.0, static_cast<int>(bits))),
        lowest_(-range),
        highest_(range - step_) {}

  bool ideal() const { return ideal_; }

  /// The level nearest to `value` [V]; counts it in `saturated` when it is beyond the range.
  double convert(double value, std::uint32_t& saturated) const {
    if (ideal_) return value;
    const double level = std::nearbyint(value / step_) * step_;
    if (level < lowest_) {
      ++saturated;
      return lowest_;
    }
    if (level > highest_) {
      ++saturated;
      return highest_;
    }
    return level;
  }

 private:
  bool ideal_;
  double step_;
  double lowest_;
  double highest_;
};

}  // namespace ring_gyro
