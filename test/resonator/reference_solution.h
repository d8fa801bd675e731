#pragma once

#include <array>
#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <complex>
#include <functional>

#include "ring_gyro/resonator/resonator_parameters.h"

namespace cvg {

/// Independent reference for the plant: equations (6)-(10) as printed in docs/derivation.md,
/// integrated in long double by a Fehlberg 7(8) method with a tight tolerance.
class ReferenceSolution {
 public:
  using Real = long double;
  using State = std::array<Real, 4>;  // x, y, x', y'
  using Signal = std::function<Real(Real)>;

  /// `gap_cubic`: a drive f acts as f (1 + gap_cubic u^2) at the displacement u of its axis.
  explicit ReferenceSolution(const ResonatorParameters& parameters, Real tolerance = 1e-15L,
                             Real gap_cubic = 0.0L)
      : parameters_(parameters), tolerance_(tolerance), gap_cubic_(gap_cubic) {}

  /// Moves `state` from t0 to t1 under drives fx, fy [V] and a rotation rate [rad/s] given in time.
  void integrate(State& state, Real t0, Real t1, const Signal& fx, const Signal& fy,
                 const Signal& rate) const {
    namespace odeint = boost::numeric::odeint;
    const ResonatorParameters& p = parameters_;
    const Real w0 = 2.0L * std::acos(-1.0L) * p.natural_frequency;
    const Real damping = w0 / p.quality_factor;
    const Real gain = p.driveGain();
    const auto equations = [&](const State& u, State& du, Real t) {
      const Real coriolis = 2.0L * p.angular_gain * rate(t);
      const Real cubic = p.cubic_stiffness * (u[0] * u[0] + u[1] * u[1]);
      du[0] = u[2];
      du[1] = u[3];
      const Real gap_x = 1 + gap_cubic_ * u[0] * u[0];
      const Real gap_y = 1 + gap_cubic_ * u[1] * u[1];
      du[2] = gain * fx(t) * gap_x + coriolis * u[3] -
              damping * ((1 + p.gamma1) * u[2] + p.gamma2 * u[3]) -
              w0 * w0 * ((1 + p.mu1 + cubic) * u[0] + p.mu2 * u[1]);
      du[3] = gain * fy(t) * gap_y - coriolis * u[2] -
              damping * (p.gamma2 * u[2] + (1 - p.gamma1) * u[3]) -
              w0 * w0 * (p.mu2 * u[0] + (1 - p.mu1 + cubic) * u[1]);
    };
    using Stepper = odeint::runge_kutta_fehlberg78<State, Real>;
    odeint::integrate_adaptive(odeint::make_controlled<Stepper>(tolerance_, tolerance_), equations,
                               state, t0, t1, 0.02L / (Real(p.natural_frequency)));
  }

 private:
  ResonatorParameters parameters_;
  Real tolerance_;
  Real gap_cubic_;
};

/// Largest difference of displacements and of velocities over w0, relative to the amplitude.
inline double relativeError(const ReferenceSolution::State& reference, const double* state,
                            double angular_frequency, double amplitude) {
  double largest = 0.0;
  for (int k = 0; k < 4; ++k) {
    const double difference = static_cast<double>(reference[k] - state[k]);
    largest = std::max(largest, std::abs(difference) / (k < 2 ? 1.0 : angular_frequency));
  }
  return largest / amplitude;
}

}  // namespace cvg
