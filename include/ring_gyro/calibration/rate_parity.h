#pragma once

#include "ring_gyro/analysis/rate_harmonics.h"
#include "ring_gyro/common/angle_harmonics.h"

namespace cvg {

/// Rates of the pattern against its angle at equal and opposite rotation: the part that does not
/// change sign with the rotation is drift, the part that does is the scale of the angle.

/// Half the sum of both, constant and all orders: theta' with the case at rest [rad/s].
AngleHarmonics evenPart(const RateHarmonics& forward, const RateHarmonics& backward);

/// Half the difference: theta' of a gyroscope without drift at the forward rate [rad/s].
AngleHarmonics oddPart(const RateHarmonics& forward, const RateHarmonics& backward);

/// Largest minus smallest value over a turn.
double peakToPeak(const AngleHarmonics& function);

/// Angle and value of the largest magnitude over a turn, the constant included.
struct Extreme {
  double theta = 0.0;  ///< [rad]
  double value = 0.0;
};
Extreme largestMagnitude(const AngleHarmonics& function);

/// The function of theta that must be added to theta so that the sum turns at a constant rate while
/// theta turns at `odd_rate` [rad/s], with `orders` harmonics: the integral of mean rate / rate,
/// minus theta [rad]. Throws std::invalid_argument when the rate changes sign.
AngleHarmonics angleMapOf(const AngleHarmonics& odd_rate, int orders);

/// Angular gain k: turns of a pattern that turns at `odd_rate` per turn of the case at
/// `rotation_rate`. Both [rad/s].
double angularGainOf(const AngleHarmonics& odd_rate, double rotation_rate);

}  // namespace cvg
