#pragma once

#include "ring_gyro/signals/envelope.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace cvg {

/// Orbit of an envelope, exact for every orbit but the circle (a = |b|), whose theta is undefined
/// and comes out finite but arbitrary. theta in [-pi, pi], phi in (-pi, 0].
Orbit orbitFromEnvelope(const Envelope& envelope);

/// Envelope [V] of an orbit, on any branch.
Envelope envelopeFromOrbit(const Orbit& orbit);

/// The five quadratic invariants, equation (26) with the sign of L_I corrected [V^2].
struct OrbitInvariants {
  double q = 0.0;    ///< 2 a b
  double s = 0.0;    ///< (a^2 - b^2) sin 2 theta
  double r = 0.0;    ///< (a^2 - b^2) cos 2 theta
  double l_r = 0.0;  ///< (a^2 - b^2) cos 2 phi
  double l_i = 0.0;  ///< -(a^2 - b^2) sin 2 phi
};

/// Invariants from the demodulated Cx, Sx, Cy, Sy (envelope = C - i S).
OrbitInvariants invariantsFromEnvelope(const Envelope& envelope);

/// Counts turns: theta without jumps, from theta known modulo 2 pi.
class AngleUnwrapper {
 public:
  /// Nearest continuation [rad] of the angles so far.
  double unwrap(double theta);
  void reset() { started_ = false; }

 private:
  bool started_ = false;
  double last_ = 0.0;
};

}  // namespace cvg
