#include "ring_gyro/resonator/ring_resonator.h"

#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

namespace ring_gyro {
namespace {

using Complex = std::complex<double>;
constexpr Complex kI{0.0, 1.0};

}  // namespace

RingResonator::RingResonator(const ResonatorParameters& parameters)
    : parameters_(parameters), drive_gain_(parameters.driveGain()) {
  solveSolvent();
}

void RingResonator::setConditions(double rotation_rate, double temperature) {
  if (rotation_rate == rotation_rate_ && temperature == temperature_) return;
  rotation_rate_ = rotation_rate;
  temperature_ = temperature;
  solveSolvent();
}

void RingResonator::solveSolvent() {
  const ResonatorParameters& p = parameters_;
  angular_frequency_ =
      p.angularFrequency() * (1.0 + p.frequency_temperature_coefficient * temperature_);
  const double quality =
      p.quality_factor * (1.0 + p.quality_temperature_coefficient * temperature_);
  const double w0 = angular_frequency_;
  Eigen::Matrix2d mismatch;
  mismatch << 1.0 + p.gamma1, p.gamma2, p.gamma2, 1.0 - p.gamma1;
  Eigen::Matrix2d gyration;
  gyration << 0.0, -1.0, 1.0, 0.0;
  damping_ = w0 / quality * mismatch + 2.0 * p.angular_gain * rotation_rate_ * gyration;
  stiffness_ << p.mu1, p.mu2, p.mu2, -p.mu1;
  stiffness_ *= w0 * w0;

  // D = S - i w0 is the small solution of D = -(D^2 + C D + i w0 C + w0^2 (M - 1)) / (2 i w0);
  // each pass shrinks the error by about |D| / w0.
  slow_.setZero();
  for (int pass = 0; pass < 50; ++pass) {
    const Eigen::Matrix2cd next =
        -(slow_ * slow_ + damping_.cast<Complex>() * slow_ + (kI * w0) * damping_.cast<Complex>() +
          stiffness_.cast<Complex>()) /
        (2.0 * kI * w0);
    const double change = (next - slow_).norm();
    slow_ = next;
    if (change <= 1e-16 * slow_.norm()) break;
  }
  const Eigen::Matrix2d imaginary = slow_.imag() + w0 * Eigen::Matrix2d::Identity();
  inverse_imaginary_ = imaginary.inverse();
}

Eigen::Vector2cd RingResonator::steadyResponse(const Eigen::Vector2cd& drive,
                                               double frequency) const {
  // w0^2 - w^2 as a product: near the resonance the difference of squares would lose digits.
  const double detuning = (angular_frequency_ - frequency) * (angular_frequency_ + frequency);
  Eigen::Matrix2cd dynamic = (kI * frequency) * damping_.cast<Complex>();
  dynamic += (stiffness_ + detuning * Eigen::Matrix2d::Identity()).cast<Complex>();
  return dynamic.inverse() * (drive_gain_ * drive);
}

Eigen::Vector2cd RingResonator::freeEnvelope(const Eigen::Vector4d& state) const {
  const Eigen::Vector2d displacement = state.head<2>();
  const Eigen::Vector2d velocity = state.tail<2>();
  const Eigen::Vector2d imaginary = inverse_imaginary_ * (slow_.real() * displacement - velocity);
  return displacement.cast<Complex>() + kI * imaginary.cast<Complex>();
}

Eigen::Vector2cd RingResonator::analyticDisplacement(const Eigen::Vector2cd& drive, double phase,
                                                     double frequency) const {
  const Eigen::Vector2cd forced = steadyResponse(drive, frequency) * std::polar(1.0, phase);
  Eigen::Vector4d free = state_;
  free.head<2>() -= forced.real();
  free.tail<2>() -= ((kI * frequency) * forced).real();
  return freeEnvelope(free) + forced;
}

const BlockMotion& RingResonator::propagate(const Eigen::Vector2cd& drive, double phase,
                                            double frequency, double duration) {
  const double w0 = parameters_.angularFrequency();  // the frame does not move with temperature
  const Eigen::Vector2cd forced = steadyResponse(drive, frequency) * std::polar(1.0, phase);
  Eigen::Vector4d free_state = state_;
  free_state.head<2>() -= forced.real();
  free_state.tail<2>() -= ((kI * frequency) * forced).real();

  // Power series of both slow motions in the frame that turns with w0.
  const Eigen::Matrix2cd step =
      duration * (slow_ + (kI * (angular_frequency_ - w0)) * Eigen::Matrix2cd::Identity());
  const Complex drift = kI * ((frequency - w0) * duration);
  Eigen::Vector2cd free_term = freeEnvelope(free_state);
  Eigen::Vector2cd forced_term = forced;
  const double scale = free_term.norm() + forced_term.norm();
  motion_.reference_frequency = w0;
  motion_.duration = duration;
  motion_.coefficients[0] = free_term + forced_term;
  motion_.terms = 1;
  while (true) {
    const double inverse = 1.0 / motion_.terms;
    free_term = (step * free_term) * inverse;
    forced_term *= drift * inverse;
    if (free_term.norm() + forced_term.norm() <= 1e-17 * scale) break;
    if (motion_.terms == BlockMotion::kMaxTerms) {
      throw std::domain_error(
          "resonator: the reference is too far from the resonance for a block this long; bring "
          "reference_frequency nearer to natural_frequency or make the blocks shorter");
    }
    motion_.coefficients[motion_.terms++] = free_term + forced_term;
  }

  // The end of the series is the new state: displacement and, by S and i w, velocity.
  const Complex turned = std::polar(1.0, w0 * duration);
  Eigen::Vector2cd forced_end = forced * std::polar(1.0, frequency * duration);
  Eigen::Vector2cd end = Eigen::Vector2cd::Zero();
  for (int k = motion_.terms - 1; k >= 0; --k) end += motion_.coefficients[k];
  end *= turned;
  const Eigen::Vector2cd free_end = end - forced_end;
  const Eigen::Vector2cd velocity =
      slow_ * free_end + (kI * angular_frequency_) * free_end + (kI * frequency) * forced_end;
  state_ << end.real(), velocity.real();
  return motion_;
}

Eigen::Matrix4d RingResonator::systemMatrix() const {
  Eigen::Matrix4d system = Eigen::Matrix4d::Zero();
  system.topRightCorner<2, 2>().setIdentity();
  system.bottomLeftCorner<2, 2>() =
      -stiffness_ - angular_frequency_ * angular_frequency_ * Eigen::Matrix2d::Identity();
  system.bottomRightCorner<2, 2>() = -damping_;
  return system;
}

}  // namespace ring_gyro
