#include "ring_gyro/control/drive_synthesis.h"

#include <cmath>
#include <complex>

namespace cvg {
namespace {

using Complex = std::complex<double>;

Envelope turnedBack(const Envelope& v) { return {v[1], -v[0]}; }  // J v

}  // namespace

Envelope velocityEnvelope(const Orbit& orbit, double reference_frequency) {
  const double c = std::cos(orbit.theta);
  const double s = std::sin(orbit.theta);
  const Complex minor(0.0, -orbit.b);
  return reference_frequency * Envelope(c * orbit.a - s * minor, s * orbit.a + c * minor);
}

DriveContributions synthesizeDrive(const Orbit& orbit, const DriveGains& gains,
                                   double reference_frequency, double drive_gain) {
  const Envelope velocity = velocityEnvelope(orbit, reference_frequency);
  const Envelope displacement = velocity / Complex(0.0, reference_frequency);
  DriveContributions drive;
  if (orbit.a > 0.0)
    drive.sustain = gains.sustain_force / (reference_frequency * orbit.a) * velocity;
  drive.quadrature = gains.alpha * turnedBack(displacement);
  drive.steering = 2.0 * gains.virtual_rate / drive_gain * turnedBack(velocity);
  const double g1 = gains.compensation.gain1;
  const double g2 = gains.compensation.gain2;
  drive.compensation = {g1 * velocity[0] + g2 * velocity[1], g2 * velocity[0] - g1 * velocity[1]};
  return drive;
}

}  // namespace cvg
