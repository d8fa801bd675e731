#pragma once

#include <Eigen/Core>

namespace cvg {

/// Orbit of the vibration over a cycle, equations (14)(15): an ellipse with major semi-axis a and
/// minor semi-axis b (signed by its sense) [V] at angle theta [rad], passed with phase phi [rad]:
///
///     [X; Y] = e^{i phi} R(theta) [a; -i b],   x(t) = Re[X e^{i psi}].
///
/// (theta + pi, phi + pi) is the same motion; phi in (-pi, 0] is the branch used throughout.
struct Orbit {
  double a = 0.0;
  double b = 0.0;
  double theta = 0.0;
  double phi = 0.0;
};

/// Orbit of an envelope, exact for every orbit but the circle (a = |b|), whose theta is undefined
/// and comes out finite but arbitrary. theta in [-pi, pi], phi in (-pi, 0].
Orbit orbitFromEnvelope(const Eigen::Vector2cd& envelope);

/// Envelope [V] of an orbit, on any branch.
Eigen::Vector2cd envelopeFromOrbit(const Orbit& orbit);

/// The five quadratic invariants, equation (26) with the sign of L_I corrected [V^2].
struct OrbitInvariants {
  double q = 0.0;    ///< 2 a b
  double s = 0.0;    ///< (a^2 - b^2) sin 2 theta
  double r = 0.0;    ///< (a^2 - b^2) cos 2 theta
  double l_r = 0.0;  ///< (a^2 - b^2) cos 2 phi
  double l_i = 0.0;  ///< -(a^2 - b^2) sin 2 phi
};

/// Invariants from the demodulated Cx, Sx, Cy, Sy (envelope = C - i S).
OrbitInvariants invariantsFromEnvelope(const Eigen::Vector2cd& envelope);

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
