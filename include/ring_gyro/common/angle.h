#pragma once

#include <cmath>

namespace cvg {

constexpr double kPi = 3.14159265358979323846;
constexpr double kTwoPi = 2.0 * kPi;

/// The angle [rad] in [-pi, pi] that differs from `angle` by whole turns. The result is bit for bit
/// that of std::remainder(angle, kTwoPi), which is slower (70 ns).
inline double wrapToPi(double angle) {
  if (std::abs(angle) < 1e6) {
    constexpr double kRound =
        6755399441055744.0;  // 1.5 2^52: a sum with it is rounded to an integer
    constexpr double kHigh = 6.283185243606567382;  // 26 bits of 2 pi: turns times it are exact
    constexpr double kLow = kTwoPi - kHigh;
    const double turns = (angle * (1.0 / kTwoPi) + kRound) - kRound;
    const double rest = (angle - turns * kHigh) - turns * kLow;
    if (std::abs(rest) < kPi) return rest;
  }
  // At half a turn the rounding of `turns` decides, which a fused multiply-add changes.
  return std::remainder(angle, kTwoPi);
}

/// For printed text only: all computations are in radians.
constexpr double toDegrees(double radians) { return radians * (180.0 / kPi); }
constexpr double toRadians(double degrees) { return degrees * (kPi / 180.0); }

}  // namespace cvg
