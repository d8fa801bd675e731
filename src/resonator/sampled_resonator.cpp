#include "ring_gyro/resonator/sampled_resonator.h"

#include <Eigen/LU>
#include <complex>
#include <unsupported/Eigen/MatrixFunctions>

namespace ring_gyro {

SampledResonator::SampledResonator(const ResonatorParameters& parameters, double sample_period)
    : parameters_(parameters), step_(sample_period / kSubsteps) {}

void SampledResonator::setLinear(const RingResonator& resonator) {
  const Eigen::Matrix4d system = resonator.systemMatrix();
  // Displacements times w0 have the size of velocities; unbalanced, the exponential loses digits.
  const double w0 = parameters_.angularFrequency();
  const Eigen::Vector4d balance(w0, w0, 1.0, 1.0);
  const Eigen::Matrix4d balanced =
      balance.asDiagonal() * system * balance.cwiseInverse().asDiagonal();
  const Eigen::Matrix4d flow = (balanced * (0.5 * step_)).exp();
  half_ = balance.cwiseInverse().asDiagonal() * flow * balance.asDiagonal();
  Eigen::Matrix<double, 4, 2> input = Eigen::Matrix<double, 4, 2>::Zero();
  input.bottomRows<2>() = resonator.driveGain() * Eigen::Matrix2d::Identity();
  held_half_ = system.inverse() * ((half_ - Eigen::Matrix4d::Identity()) * input);
}

Eigen::Vector4d SampledResonator::halfFlow(const Eigen::Vector4d& state, const SampleDrive& drive,
                                           const Eigen::Vector2cd& forced_begin,
                                           const Eigen::Vector2cd& forced_end) const {
  if (drive.held) return half_ * state + held_half_ * drive.value;
  const std::complex<double> rate(0.0, drive.frequency);
  const auto motion = [&](const Eigen::Vector2cd& forced) {
    return Eigen::Vector4d(forced[0].real(), forced[1].real(), (rate * forced[0]).real(),
                           (rate * forced[1]).real());
  };
  return half_ * (state - motion(forced_begin)) + motion(forced_end);
}

Eigen::Vector4d SampledResonator::rest(const Eigen::Vector4d& state, double extra_rate) const {
  const double w0 = parameters_.angularFrequency();
  const double stiffening = -w0 * w0 * parameters_.cubic_stiffness * state.head<2>().squaredNorm();
  const double coriolis = 2.0 * parameters_.angular_gain * extra_rate;
  return {0.0, 0.0, stiffening * state[0] + coriolis * state[3],
          stiffening * state[1] - coriolis * state[2]};
}

Eigen::Vector4d SampledResonator::step(const RingResonator& resonator, const Eigen::Vector4d& state,
                                       const SampleDrive& drive, double time,
                                       const std::function<double(double)>& extra_rate) const {
  const Eigen::Vector2cd response = drive.held
                                        ? Eigen::Vector2cd::Zero()
                                        : resonator.steadyResponse(drive.envelope, drive.frequency);
  Eigen::Vector4d moved = state;
  for (int k = 0; k < kSubsteps; ++k) {
    const double offset = k * step_;
    const Eigen::Vector2cd forced =
        response * std::polar(1.0, drive.phase + drive.frequency * offset);
    moved = substep(moved, drive, forced, time + offset, extra_rate);
  }
  return moved;
}

Eigen::Vector4d SampledResonator::substep(const Eigen::Vector4d& state, const SampleDrive& drive,
                                          const Eigen::Vector2cd& forced_begin, double time,
                                          const std::function<double(double)>& extra_rate) const {
  const double h = step_;
  const double rate_begin = extra_rate(time);
  const double rate_middle = extra_rate(time + 0.5 * h);
  const double rate_end = extra_rate(time + h);
  const std::complex<double> half_turn = std::polar(1.0, 0.5 * h * drive.frequency);
  const Eigen::Vector2cd forced_middle = forced_begin * half_turn;
  const Eigen::Vector2cd forced_end = forced_middle * half_turn;
  const Eigen::Vector4d middle = halfFlow(state, drive, forced_begin, forced_middle);
  const Eigen::Vector4d end = halfFlow(middle, drive, forced_middle, forced_end);

  const Eigen::Vector4d k1 = half_ * rest(state, rate_begin);
  const Eigen::Vector4d k2 = rest(middle + 0.5 * h * k1, rate_middle);
  const Eigen::Vector4d k3 = rest(middle + 0.5 * h * k2, rate_middle);
  const Eigen::Vector4d k4 = rest(end + h * (half_ * k3), rate_end);
  return end + (h / 6.0) * (half_ * (k1 + 2.0 * (k2 + k3)) + k4);
}

}  // namespace ring_gyro
