#include "ring_gyro/identification/model/averaged_model.h"

#include <cmath>
#include <complex>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/identification/model/axes_equation.h"

namespace cvg {
namespace {

AxesDynamics<double> dynamicsAt(const AveragedModel& model, const Orbit& orbit,
                                const AveragedInput& input) {
  return {model.decayRate(), model.angularFrequency(), averagedStep(orbit.theta, orbit.phi, input)};
}

}  // namespace

Envelope driveStep(const Envelope& before, const Envelope& after, double reference_phase,
                   double reference_frequency, double duration) {
  // i (S - S* e^{-2 i psi}) / (2 w duration)
  const Phasor<double> image = {std::cos(-2.0 * reference_phase), std::sin(-2.0 * reference_phase)};
  const double spread = 0.5 / (reference_frequency * duration);
  const auto added = [&](const std::complex<double>& change) {
    const Phasor<double> s = phasor(change);
    const Phasor<double> result = spread * timesI(s - conjugate(s) * image);
    return std::complex<double>(result.re, result.im);
  };
  return {added(after.x() - before.x()), added(after.y() - before.y())};
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
  const double k2_mc = dynamics.k2 * (device.mu1 * dynamics.c + device.mu2 * dynamics.s);
  const double d_gs = decay_rate_ * (device.gamma2 * dynamics.c - device.gamma1 * dynamics.s);

  // r1 = phi' a + theta' b and r2 = phi' b + theta' a (docs/derivation.md, section 4).
  const double r1 = (detuning + k2_mc) * a + (d_gs - input.rotation_rate) * b -
                    device.drive_gain * dynamics.f1.re;
  const double r2 = (detuning - k2_mc) * b - (d_gs + input.rotation_rate) * a +
                    device.drive_gain * dynamics.f2.im;
  const double difference = a * a - b * b;

  const Vector2 axes = AxesEquation(dynamics, device).rate(Vector2{a, b});
  OrbitRates rates;
  rates.a = axes[0];                             // (16)
  rates.b = axes[1];                             // (17)
  rates.theta = (a * r2 - b * r1) / difference;  // (18)
  rates.phi = (a * r1 - b * r2) / difference;    // (19)
  return rates;
}

AxesRates AveragedModel::axesRates(const Orbit& orbit, const DeviceParameters& device,
                                   const AveragedInput& input) const {
  const AxesDynamics<double> dynamics = dynamicsAt(*this, orbit, input);
  const AxesEquation equation(dynamics, device);
  const Vector2 axes = {orbit.a, orbit.b};
  AxesRates result;
  result.rate = eigen(equation.rate(axes));
  result.by_axes = eigen(equation.m);
  result.by_angles = eigen(equation.byAngles(axes));
  result.by_parameters =
      eigen(equation.byParameters(equation.byGamma(axes), equation.byMu(axes), equation.f));
  return result;
}

AxesStep AveragedModel::axesStep(const Orbit& orbit, const DeviceParameters& device,
                                 const AveragedInput& input, double duration) const {
  const AxesDynamics<double> dynamics = dynamicsAt(*this, orbit, input);
  const AxesStepResult taken =
      AxesEquation(dynamics, device).step(Vector2{orbit.a, orbit.b}, duration);
  AxesStep step;
  step.axes = eigen(taken.axes);
  step.by_axes = eigen(taken.by_axes);
  step.rate_by_angles = eigen(taken.rate_by_angles);
  step.by_parameters = eigen(taken.by_parameters);
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
