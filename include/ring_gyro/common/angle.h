#pragma once

#include <cmath>

namespace ring_gyro {

constexpr double kPi = 3.14159265358979323846;
constexpr double kTwoPi = 2.0 * kPi;

/// The angle [rad] that differs from `angle` by whole turns and lies in [-pi, pi].
inline double wrapToPi(double angle) { return std::remainder(angle, kTwoPi); }

/// For people only: everything inside is in radians.
constexpr double toDegrees(double radians) { return radians * (180.0 / kPi); }
constexpr double toRadians(double degrees) { return degrees * (kPi / 180.0); }

}  // namespace ring_gyro
