#include "ring_gyro/demodulation/orbit.h"

#include <cmath>
#include <complex>

#include "ring_gyro/common/angle.h"

namespace cvg {
namespace {

using Complex = std::complex<double>;
constexpr Complex kI{0.0, 1.0};

}  // namespace

Orbit orbitFromEnvelope(const Envelope& envelope) {
  // The two circular motions: X + iY = e^{i(phi+theta)} (a+b), X - iY = e^{i(phi-theta)} (a-b).
  const Complex left = envelope[0] + kI * envelope[1];
  const Complex right = envelope[0] - kI * envelope[1];
  const double left_angle = std::arg(left);
  const double right_angle = std::arg(right);
  Orbit orbit;
  // std::abs would take about 20 ns more to guard against overflow, which voltages do not need.
  const double left_radius = std::sqrt(std::norm(left));
  const double right_radius = std::sqrt(std::norm(right));
  orbit.a = 0.5 * (left_radius + right_radius);
  orbit.b = 0.5 * (left_radius - right_radius);
  orbit.phi = 0.5 * (left_angle + right_angle);
  orbit.theta = 0.5 * (left_angle - right_angle);
  // phi is now in [-pi, pi]; a turn of pi of both angles is the same motion.
  if (orbit.phi > 0.0) {
    orbit.phi -= kPi;
    orbit.theta += kPi;
  } else if (orbit.phi <= -kPi) {
    orbit.phi += kPi;
    orbit.theta -= kPi;
  }
  orbit.theta = wrapToPi(orbit.theta);
  return orbit;
}

Envelope envelopeFromOrbit(const Orbit& orbit) {
  const double c = std::cos(orbit.theta);
  const double s = std::sin(orbit.theta);
  const Complex major(orbit.a, 0.0);
  const Complex minor(0.0, -orbit.b);
  const Complex turn = std::polar(1.0, orbit.phi);
  return {turn * (c * major - s * minor), turn * (s * major + c * minor)};
}

double AngleUnwrapper::unwrap(double theta) {
  last_ = started_ ? last_ + wrapToPi(theta - last_) : theta;
  started_ = true;
  return last_;
}

}  // namespace cvg
