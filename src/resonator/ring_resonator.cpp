#include "ring_gyro/resonator/ring_resonator.h"

#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

#include "ring_gyro/common/slow_motion.h"

namespace cvg {
namespace {

using Complex = std::complex<double>;
constexpr Complex kI{0.0, 1.0};

}  // namespace

RingResonator::RingResonator(const ResonatorParameters& parameters)
    : parameters_(parameters), drive_gain_(parameters.driveGain()) {
  solveSlowMotion();
}

void RingResonator::setConditions(double rotation_rate, double temperature) {
  if (rotation_rate == rotation_rate_ && temperature == temperature_) return;
  rotation_rate_ = rotation_rate;
  temperature_ = temperature;
  solveSlowMotion();
}

void RingResonator::solveSlowMotion() {
  ++condition_changes_;
  const ResonatorParameters& p = parameters_;
  angular_frequency_ =
      p.angularFrequency() * (1.0 + p.frequency_temperature_coefficient * temperature_);
  const double quality =
      p.quality_factor * (1.0 + p.quality_temperature_coefficient * temperature_);
  const double w0 = angular_frequency_;
  const double gamma_change = 1.0 + p.gamma_temperature_coefficient * temperature_;
  const double gamma1 = p.gamma1 * gamma_change;
  const double gamma2 = p.gamma2 * gamma_change;
  Eigen::Matrix2d mismatch;
  mismatch << 1.0 + gamma1, gamma2, gamma2, 1.0 - gamma1;
  Eigen::Matrix2d gyration;
  gyration << 0.0, -1.0, 1.0, 0.0;
  damping_ = w0 / quality * mismatch + 2.0 * p.angular_gain * rotation_rate_ * gyration;
  stiffness_ << p.mu1, p.mu2, p.mu2, -p.mu1;
  stiffness_ *= w0 * w0;

  slow_ = cvg::slowMotion(w0, damping_, stiffness_);
  const Eigen::Matrix2d imaginary = slow_.imag() + w0 * Eigen::Matrix2d::Identity();
  inverse_imaginary_ = imaginary.inverse();
}

Eigen::Vector2cd RingResonator::steadyResponse(const Eigen::Vector2cd& drive,
                                               double frequency) const {
  // w0^2 - w^2 as a product: near the resonance the difference of squares would lose digits.
  const double detuning = (angular_frequency_ - frequency) * (angular_frequency_ + frequency);
  // (w0^2 M - w^2 + i w C) X = ks F, by Cramer's rule.
  const auto entry = [&](int row, int column, double diagonal) {
    return Complex(stiffness_(row, column) + diagonal, frequency * damping_(row, column));
  };
  const Complex xx = entry(0, 0, detuning);
  const Complex xy = entry(0, 1, 0.0);
  const Complex yx = entry(1, 0, 0.0);
  const Complex yy = entry(1, 1, detuning);
  const Complex determinant = xx * yy - xy * yx;
  const Complex scale = std::conj(determinant) * (drive_gain_ / std::norm(determinant));
  return {scale * (yy * drive[0] - xy * drive[1]), scale * (xx * drive[1] - yx * drive[0])};
}

ForcedMotion RingResonator::steadyMotion(const DriveForce& drive, double frequency) const {
  ForcedMotion motion;
  motion.frequency = frequency;
  motion.fundamental = steadyResponse(drive.fundamental, frequency);
  motion.harmonic = drive.harmonic();
  if (!motion.harmonic) {
    motion.constant = compliance() * drive.constant;
    motion.second = steadyResponse(drive.second, 2.0 * frequency);
  }
  return motion;
}

Eigen::Matrix2d RingResonator::compliance() const {
  const double w2 = angular_frequency_ * angular_frequency_;
  return drive_gain_ * (stiffness_ + w2 * Eigen::Matrix2d::Identity()).inverse();
}

Eigen::Vector2cd RingResonator::freeEnvelope(const Eigen::Vector4d& state) const {
  // u + i Im(S)^-1 (Re(S) u - v)
  const double x = slow_(0, 0).real() * state[0] + slow_(0, 1).real() * state[1] - state[2];
  const double y = slow_(1, 0).real() * state[0] + slow_(1, 1).real() * state[1] - state[3];
  return {Complex(state[0], inverse_imaginary_(0, 0) * x + inverse_imaginary_(0, 1) * y),
          Complex(state[1], inverse_imaginary_(1, 0) * x + inverse_imaginary_(1, 1) * y)};
}

Eigen::Vector2cd RingResonator::analyticDisplacement(const ForcedMotion& forced,
                                                     const Complex& turn) const {
  return freeEnvelope(state_ - forced.atTurn(turn)) + forced.fundamental * turn;
}

const BlockMotion& RingResonator::propagate(const ForcedMotion& steady, double phase,
                                            double duration) {
  const double w0 = parameters_.angularFrequency();  // the frame does not move with temperature
  const double frequency = steady.frequency;
  const Complex begin_turn = std::polar(1.0, phase);
  const Eigen::Vector4d free_state = state_ - steady.atTurn(begin_turn);
  const Eigen::Vector2cd forced = steady.fundamental * begin_turn;

  motion_.reference_frequency = w0;
  motion_.duration = duration;
  motion_.constant = steady.constant;
  motion_.second = steady.second * (begin_turn * begin_turn);
  motion_.second_frequency = 2.0 * frequency;
  Eigen::Vector2cd end = expand(freeEnvelope(free_state), forced, (frequency - w0) * duration);

  // The end of the series is the new state: displacement and, by S and i w, velocity.
  if (duration != turned_duration_) {
    turned_duration_ = duration;
    turn_ = std::polar(1.0, w0 * duration);
  }
  end *= turn_;
  const Complex forced_turn = std::polar(1.0, frequency * duration);
  const Eigen::Vector2cd forced_end = forced * forced_turn;
  motion_.end_turn = begin_turn * forced_turn;
  const Eigen::Vector2cd free_end = end - forced_end;
  const Eigen::Vector2cd velocity =
      slow_ * free_end + (kI * angular_frequency_) * free_end + (kI * frequency) * forced_end;
  state_ << end.real(), velocity.real();
  if (!steady.harmonic) {
    const Eigen::Vector2cd second_end = motion_.second * (forced_turn * forced_turn);
    state_.head<2>() += motion_.constant + second_end.real();
    state_.tail<2>() -= 2.0 * frequency * second_end.imag();
  }
  return motion_;
}

// Power series of both slow motions in the frame that turns with w0: the free motion with e^{step},
// the forced motion with e^{i drift}. Fills the series of the samples and gives the sum at the
// block's end. Uses real numbers for speed: this is the longest chain of operations of a block.
Eigen::Vector2cd RingResonator::expand(const Eigen::Vector2cd& free, const Eigen::Vector2cd& forced,
                                       double drift) {
  constexpr double kSampleShare = 1e-13;  // squared below; of the motion
  constexpr double kEndShare = 1e-17;     // errors of the state accumulate
  const double w0 = parameters_.angularFrequency();
  const double duration = motion_.duration;
  const double slip = angular_frequency_ - w0;
  const double s00r = duration * slow_(0, 0).real();
  const double s00i = duration * (slow_(0, 0).imag() + slip);
  const double s01r = duration * slow_(0, 1).real();
  const double s01i = duration * slow_(0, 1).imag();
  const double s10r = duration * slow_(1, 0).real();
  const double s10i = duration * slow_(1, 0).imag();
  const double s11r = duration * slow_(1, 1).real();
  const double s11i = duration * (slow_(1, 1).imag() + slip);
  double xr = free[0].real(), xi = free[0].imag(), yr = free[1].real(), yi = free[1].imag();
  double pr = forced[0].real(), pi = forced[0].imag(), qr = forced[1].real(), qi = forced[1].imag();
  const auto size = [&] {
    return (xr * xr + xi * xi + yr * yr + yi * yi) + (pr * pr + pi * pi + qr * qr + qi * qi);
  };
  const double scale = size();
  PhasorSeries& series = motion_.series;
  double end_xr = 0.0, end_xi = 0.0, end_yr = 0.0, end_yi = 0.0;
  double left = scale;
  int terms = 0;
  series.terms = 0;
  while (true) {
    series.x_real[terms] = xr + pr;
    series.x_imaginary[terms] = xi + pi;
    series.y_real[terms] = yr + qr;
    series.y_imaginary[terms] = yi + qi;
    end_xr += xr + pr;
    end_xi += xi + pi;
    end_yr += yr + qr;
    end_yi += yi + qi;
    ++terms;
    if (left > kSampleShare * kSampleShare * scale || terms == 1) series.terms = terms;
    const double inverse = 1.0 / terms;
    const double new_xr = inverse * ((s00r * xr - s00i * xi) + (s01r * yr - s01i * yi));
    const double new_xi = inverse * ((s00r * xi + s00i * xr) + (s01r * yi + s01i * yr));
    const double new_yr = inverse * ((s10r * xr - s10i * xi) + (s11r * yr - s11i * yi));
    const double new_yi = inverse * ((s10r * xi + s10i * xr) + (s11r * yi + s11i * yr));
    xr = new_xr, xi = new_xi, yr = new_yr, yi = new_yi;
    const double turned = drift * inverse;
    const double new_pr = -turned * pi;
    const double new_qr = -turned * qi;
    pi = turned * pr, qi = turned * qr;
    pr = new_pr, qr = new_qr;
    left = size();
    if (left <= kEndShare * kEndShare * scale) break;
    if (terms == PhasorSeries::kMaxTerms) {
      throw std::domain_error(
          "resonator: the reference is too far from the resonance for a block this long; bring "
          "reference_frequency nearer to natural_frequency or make the blocks shorter");
    }
  }
  return {Complex(end_xr, end_xi), Complex(end_yr, end_yi)};
}

Eigen::Matrix4d RingResonator::flow(double time) const {
  // u = Re[z], v = Re[S z] and z = u + i Im(S)^-1 (Re(S) u - v), as in freeEnvelope.
  const Eigen::Matrix2cd solvent = slow_ + (kI * angular_frequency_) * Eigen::Matrix2cd::Identity();
  Eigen::Matrix<Complex, 2, 4> complexified;
  complexified.leftCols<2>() = Eigen::Matrix2cd::Identity();
  complexified.leftCols<2>() += kI * (inverse_imaginary_ * slow_.real()).cast<Complex>();
  complexified.rightCols<2>() = -kI * inverse_imaginary_.cast<Complex>();

  const Eigen::Matrix2cd step = time * slow_;
  Eigen::Matrix2cd term = Eigen::Matrix2cd::Identity();
  Eigen::Matrix2cd exponential = term;
  for (int k = 1; k < PhasorSeries::kMaxTerms && term.norm() > 1e-18; ++k) {
    term = (term * step).eval() / static_cast<double>(k);
    exponential += term;
  }
  exponential *= std::polar(1.0, angular_frequency_ * time);
  const Eigen::Matrix<Complex, 2, 4> moved = exponential * complexified;
  Eigen::Matrix4d flow;
  flow << moved.real(), (solvent * moved).real();
  return flow;
}

}  // namespace cvg
