#include "ring_gyro/identification/model/averaged_model.h"

#include <cmath>
#include <complex>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/identification/model/axes_dynamics.h"

namespace cvg {
namespace {

Eigen::Vector2d vectorOf(const TwoLanes& pair) { return {pair[0], pair[1]}; }

Eigen::Matrix2d matrixOf(const Square& matrix) {
  Eigen::Matrix2d result;
  result << vectorOf(matrix.first), vectorOf(matrix.second);
  return result;
}

AxesDynamics<double> dynamicsAt(const AveragedModel& model, const Orbit& orbit,
                                const AveragedInput& input) {
  return {model.decayRate(), model.angularFrequency(), averagedStep(orbit.theta, orbit.phi, input)};
}

/// Of one component of driveStep(): `turn_re` + i `turn_im`: e^{-2 i psi}.
std::complex<double> stepImage(std::complex<double> step, double turn_re, double turn_im,
                               double spread) {
  const double re = step.real() - (step.real() * turn_re + step.imag() * turn_im);
  const double im = step.imag() - (step.real() * turn_im - step.imag() * turn_re);
  return {-spread * im, spread * re};
}

}  // namespace

Eigen::Vector2cd driveStep(const Eigen::Vector2cd& before, const Eigen::Vector2cd& after,
                           double reference_phase, double reference_frequency, double duration) {
  const Eigen::Vector2cd step = after - before;
  const double spread = 0.5 / (reference_frequency * duration);
  const double cosine = std::cos(-2.0 * reference_phase);
  const double sine = std::sin(-2.0 * reference_phase);
  return {stepImage(step.x(), cosine, sine, spread), stepImage(step.y(), cosine, sine, spread)};
}

AveragedModel::AveragedModel(const DeviceKnowledge& device)
    : angular_frequency_(device.angularFrequency()), decay_rate_(device.decayRate()) {
  device.requireResonance("averaged model");
}

OrbitRates AveragedModel::rates(const Orbit& orbit, const DeviceParameters& device,
                                const AveragedInput& input) const {
  const AxesDynamics<double> dynamics = dynamicsAt(*this, orbit, input);
  const double a = orbit.a;
  const double b = orbit.b;
  const double frequency = input.reference_frequency;
  const double detuning = 0.5 * (angular_frequency_ * angular_frequency_ / frequency - frequency);
  const double mu_along =
      dynamics.coupling * (device.mu1 * dynamics.cosine + device.mu2 * dynamics.sine);
  const double gamma_across =
      decay_rate_ * (device.gamma2 * dynamics.cosine - device.gamma1 * dynamics.sine);

  // phi' a + theta' b and phi' b + theta' a: the rates at which the envelope turns, in pattern
  // axes.
  const double along = (detuning + mu_along) * a + (gamma_across - input.rotation_rate) * b -
                       device.drive_gain * dynamics.along_real;
  const double across = (detuning - mu_along) * b - (gamma_across + input.rotation_rate) * a +
                        device.drive_gain * dynamics.across_imaginary;
  const double difference = a * a - b * b;

  const AxesRatePairs of_axes(dynamics, device);
  const TwoLanes axes = of_axes.rate(TwoLanes{a, b});
  OrbitRates rates;
  rates.a = axes[0];                                    // (16)
  rates.b = axes[1];                                    // (17)
  rates.theta = (a * across - b * along) / difference;  // (18)
  rates.phi = (a * along - b * across) / difference;    // (19)
  return rates;
}

AxesRates AveragedModel::axesRates(const Orbit& orbit, const DeviceParameters& device,
                                   const AveragedInput& input) const {
  const AxesDynamics<double> dynamics = dynamicsAt(*this, orbit, input);
  const AxesRatePairs rates(dynamics, device);
  const TwoLanes axes = {orbit.a, orbit.b};
  AxesRates result;
  result.rate = vectorOf(rates.rate(axes));
  result.by_axes = matrixOf(rates.by_axes);
  result.by_angles = matrixOf(rates.byAngles(axes));
  result.by_parameters =
      rates.byParameters(rates.byGamma(axes), rates.byMu(axes), rates.force).matrix();
  return result;
}

AxesStep AveragedModel::axesStep(const Orbit& orbit, const DeviceParameters& device,
                                 const AveragedInput& input, double duration) const {
  const AxesDynamics<double> dynamics = dynamicsAt(*this, orbit, input);
  const AxesStepPairs pairs =
      AxesRatePairs(dynamics, device).step(TwoLanes{orbit.a, orbit.b}, duration);
  AxesStep step;
  step.axes = vectorOf(pairs.axes);
  step.by_axes = matrixOf(pairs.by_axes);
  step.rate_by_angles = matrixOf(pairs.rate_by_angles);
  step.by_parameters = pairs.by_parameters.matrix();
  return step;
}

Orbit AveragedModel::integrate(const Orbit& orbit, const DeviceParameters& device,
                               const AveragedInput& input, double duration, int steps) const {
  const double h = duration / steps;
  const auto moved = [](const Orbit& from, const OrbitRates& rates, double time) {
    return Orbit{from.a + time * rates.a, from.b + time * rates.b, from.theta + time * rates.theta,
                 from.phi + time * rates.phi};
  };
  Orbit now = orbit;
  for (int k = 0; k < steps; ++k) {
    const OrbitRates first = rates(now, device, input);
    const OrbitRates second = rates(moved(now, first, 0.5 * h), device, input);
    const OrbitRates third = rates(moved(now, second, 0.5 * h), device, input);
    const OrbitRates fourth = rates(moved(now, third, h), device, input);
    const auto mean = [](double k1, double k2, double k3, double k4) {
      return (k1 + 2.0 * (k2 + k3) + k4) / 6.0;
    };
    now = moved(
        now,
        {mean(first.a, second.a, third.a, fourth.a), mean(first.b, second.b, third.b, fourth.b),
         mean(first.theta, second.theta, third.theta, fourth.theta),
         mean(first.phi, second.phi, third.phi, fourth.phi)},
        h);
  }
  return now;
}

}  // namespace cvg
