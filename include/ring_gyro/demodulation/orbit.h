#pragma once

#include "ring_gyro/signals/envelope.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace cvg {

/// Orbit of an envelope, exact except for a circle (a = |b|), whose theta is undefined; the result
/// is then finite but arbitrary. theta in [-pi, pi], phi in (-pi, 0].
Orbit orbitFromEnvelope(const Envelope& envelope);

/// Envelope [V] of an orbit, on any branch.
Envelope envelopeFromOrbit(const Orbit& orbit);

/// Counts turns: theta without jumps, from theta known modulo 2 pi.
class AngleUnwrapper {
 public:
  /// The angle [rad] equal to theta modulo 2 pi that is nearest to the previous result.
  double unwrap(double theta);
  void reset() { started_ = false; }

 private:
  bool started_ = false;
  double last_ = 0.0;
};

}  // namespace cvg
