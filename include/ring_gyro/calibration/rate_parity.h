#pragma once

#include "ring_gyro/analysis/rate_harmonics.h"
#include "ring_gyro/common/angle_harmonics.h"

namespace cvg {

/// Rates of the pattern against its angle at equal and opposite rotation: what does not change sign
/// with the rotation is drift, what does is the scale of the angle.

/// Half the sum of both, constant and all orders: theta' with the case at rest [rad/s].
AngleHarmonics evenPart(const RateHarmonics& forward, const RateHarmonics& backward);

/// Half the difference: theta' of a gyroscope without drift at the forward rate [rad/s].
AngleHarmonics oddPart(const RateHarmonics& forward, const RateHarmonics& backward);

/// Largest less smallest over a turn.
double peakToPeak(const AngleHarmonics& function);

/// Angle and value of the largest magnitude over a turn, the constant included.
struct Extreme {
  double theta = 0.0;  ///< [rad]
  double value = 0.0;
};
Extreme largestMagnitude(const AngleHarmonics& function);

/// What must be added to theta so that the sum turns evenly where theta turns at `odd_rate`
/// [rad/s], with `orders` harmonics: the integral of the mean rate over the rate, less theta [rad].
/// The rate must not change sign (std::invalid_argument).
AngleHarmonics angleMapOf(const AngleHarmonics& odd_rate, int orders);

/// Turns of the pattern per turn in which it turned at `odd_rate`, over that of the case at
/// `rotation_rate`: the angular gain k. Both [rad/s].
double angularGainOf(const AngleHarmonics& odd_rate, double rotation_rate);

}  // namespace cvg
