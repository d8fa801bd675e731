#include "ring_gyro/identification/filter/first_look.h"

#include <cmath>
#include <complex>

#include "ring_gyro/common/angle.h"

namespace cvg {

void FirstLookSum::add(const Orbit& orbit, const Envelope& drive, double reference_frequency) {
  const std::complex<double> along =
      std::cos(orbit.theta) * drive.x() + std::sin(orbit.theta) * drive.y();
  amplitude_ += orbit.a;
  frequency_ += reference_frequency;
  drive_ += (std::polar(1.0, -orbit.phi) * along).imag();
  if (blocks_ == 0) first_phi_ = orbit.phi;
  last_phi_ = orbit.phi;
  ++blocks_;
}

FirstLook FirstLookSum::look(double duration, double decay_rate) const {
  const double frequency = frequency_ / blocks_;
  // phi' = w0 - w if mu is neglected.
  const double slip = blocks_ > 1 ? (last_phi_ - first_phi_) / ((blocks_ - 1) * duration) : 0.0;
  return {amplitude_ / blocks_, 2.0 * frequency * decay_rate * amplitude_ / drive_,
          (frequency + slip) / kTwoPi};
}

}  // namespace cvg
