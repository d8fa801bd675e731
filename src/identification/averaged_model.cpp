#include "ring_gyro/identification/averaged_model.h"

#include <cmath>
#include <complex>
#include <stdexcept>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/sine_cosine.h"
#include "ring_gyro/common/vector_dispatch.h"

namespace ring_gyro {
namespace {

/// Drive along and across the pattern, E F1 and E F2 with [F1; F2] = R(-theta) F, E = e^{-i phi}.
struct PatternDrive {
  std::complex<double> along;
  std::complex<double> across;
};

/// `re` + i `im`: E.
PatternDrive turnDrive(double cosine, double sine, double re, double im,
                       const Eigen::Vector2cd& drive) {
  // Written out: a std::complex product also checks for NaN, which costs more than it computes.
  const auto turn = [re, im](std::complex<double> z) {
    return std::complex<double>(re * z.real() - im * z.imag(), re * z.imag() + im * z.real());
  };
  return {turn(cosine * drive.x() + sine * drive.y()), turn(cosine * drive.y() - sine * drive.x())};
}

/// Of one component of driveStep(): `turn_re` + i `turn_im`: e^{-2 i psi}.
std::complex<double> stepImage(std::complex<double> step, double turn_re, double turn_im,
                               double spread) {
  const double re = step.real() - (step.real() * turn_re + step.imag() * turn_im);
  const double im = step.imag() - (step.real() * turn_im - step.imag() * turn_re);
  return {-spread * im, spread * re};
}

}  // namespace

/// a' and b' as what they are at given angles: linear in (a, b), in the parameters and in the
/// drive.
struct AveragedModel::AxesDynamics {
  double decay;     // xi0 w0
  double coupling;  // w0^2 / (2 w)
  double turning;   // theta' / (2 w)
  double cosine;    // of 2 theta
  double sine;
  PatternDrive drive;
  Eigen::Vector2d force;            // rate of (a, b) per ks
  Eigen::Matrix2d force_by_angles;  // with respect to (theta, phi)

  AxesDynamics(const AveragedModel& model, const Orbit& orbit, const AveragedInput& input)
      : decay(model.decay_rate_) {
    const SineCosine<2> angles = sineCosine<2>({orbit.theta, orbit.phi});
    const double theta_cosine = angles.cosine[0];
    const double theta_sine = angles.sine[0];
    drive = turnDrive(theta_cosine, theta_sine, angles.cosine[1], -angles.sine[1], input.drive);
    const double scale = 0.5 / input.reference_frequency;
    coupling = scale * model.angular_frequency_ * model.angular_frequency_;
    turning = scale * input.pattern_rate;
    cosine = theta_cosine * theta_cosine - theta_sine * theta_sine;
    sine = 2.0 * theta_cosine * theta_sine;
    force << scale * drive.along.imag(), scale * drive.across.real();
    // Turning the pattern turns F1 into F2 and F2 into -F1; turning phi multiplies both by -i.
    force_by_angles << scale * drive.across.imag(), -scale * drive.along.real(),
        -scale * drive.along.real(), scale * drive.across.imag();
  }

  double alongAxes(double first, double second) const { return first * cosine + second * sine; }
  double acrossAxes(double first, double second) const { return second * cosine - first * sine; }

  // Damping and stiffness act on the motion, whose axes are not quite those of the envelope while
  // the pattern turns: on (a + e b, b + e a) and (a - e b, b - e a), e = theta' / (2 w).
  Eigen::Vector2d dampedAxes(const Eigen::Vector2d& axes) const {
    return {axes[0] + turning * axes[1], axes[1] + turning * axes[0]};
  }
  Eigen::Vector2d sprungAxes(const Eigen::Vector2d& axes) const {
    return {axes[0] - turning * axes[1], axes[1] - turning * axes[0]};
  }

  Eigen::Matrix2d matrix(const DeviceParameters& device) const {
    const double gamma = alongAxes(device.gamma1, device.gamma2);
    const double mu = coupling * acrossAxes(device.mu1, device.mu2);
    const double a_decay = decay * (1.0 + gamma);
    const double b_decay = decay * (1.0 - gamma);
    Eigen::Matrix2d result;
    result << -a_decay - turning * mu, mu - turning * a_decay,  //
        -mu - turning * b_decay, -b_decay + turning * mu;
    return result;
  }

  /// Rates with respect to what gamma, and w0 mu, are along and across the axes.
  Eigen::Vector2d byGamma(const Eigen::Vector2d& axes) const {
    return {-decay * (axes[0] + turning * axes[1]), decay * (axes[1] + turning * axes[0])};
  }
  Eigen::Vector2d byMu(const Eigen::Vector2d& axes) const {
    return {coupling * (axes[1] - turning * axes[0]), -coupling * (axes[0] - turning * axes[1])};
  }

  Eigen::Matrix<double, 2, 5> byParameters(const Eigen::Vector2d& axes) const {
    Eigen::Matrix<double, 2, 5> result;
    result << cosine * byGamma(axes), sine * byGamma(axes), -sine * byMu(axes), cosine * byMu(axes),
        force;
    return result;
  }

  Eigen::Matrix2d byAngles(const Eigen::Vector2d& axes, const DeviceParameters& device) const {
    const double gamma_slope = 2.0 * decay * acrossAxes(device.gamma1, device.gamma2);
    const double mu_slope = -2.0 * coupling * alongAxes(device.mu1, device.mu2);
    const Eigen::Vector2d damped = dampedAxes(axes);
    const Eigen::Vector2d sprung = sprungAxes(axes);
    Eigen::Matrix2d result = device.drive_gain * force_by_angles;
    result(0, 0) += -gamma_slope * damped[0] + mu_slope * sprung[1];
    result(1, 0) += gamma_slope * damped[1] - mu_slope * sprung[0];
    return result;
  }
};

RING_GYRO_FLATTEN Eigen::Vector2cd driveStep(const Eigen::Vector2cd& before,
                                             const Eigen::Vector2cd& after, double reference_phase,
                                             double reference_frequency, double duration) {
  const Eigen::Vector2cd step = after - before;
  const double spread = 0.5 / (reference_frequency * duration);
  const SineCosine<1> turn = sineCosine<1>(Eigen::Array<double, 1, 1>(-2.0 * reference_phase));
  return {stepImage(step.x(), turn.cosine[0], turn.sine[0], spread),
          stepImage(step.y(), turn.cosine[0], turn.sine[0], spread)};
}

AveragedModel::AveragedModel(double natural_frequency, double quality_factor)
    : angular_frequency_(kTwoPi * natural_frequency),
      decay_rate_(0.5 * angular_frequency_ / quality_factor) {
  if (!(natural_frequency > 0.0) || !std::isfinite(natural_frequency)) {
    throw std::invalid_argument("averaged model: natural_frequency must be above 0 Hz");
  }
  if (!(quality_factor > 0.0) || !std::isfinite(quality_factor)) {
    throw std::invalid_argument("averaged model: quality_factor must be above 0");
  }
}

OrbitRates AveragedModel::rates(const Orbit& orbit, const DeviceParameters& device,
                                const AveragedInput& input) const {
  const AxesDynamics dynamics(*this, orbit, input);
  const PatternDrive& drive = dynamics.drive;
  const double a = orbit.a;
  const double b = orbit.b;
  const double frequency = input.reference_frequency;
  const double detuning = 0.5 * (angular_frequency_ * angular_frequency_ / frequency - frequency);
  const double drive_scale = 0.5 * device.drive_gain / frequency;
  const double mu_along = dynamics.coupling * dynamics.alongAxes(device.mu1, device.mu2);
  const double gamma_across = decay_rate_ * dynamics.acrossAxes(device.gamma1, device.gamma2);

  // phi' a + theta' b and phi' b + theta' a: the rates at which the envelope turns, in pattern
  // axes.
  const double along = (detuning + mu_along) * a + (gamma_across - input.rotation_rate) * b -
                       drive_scale * drive.along.real();
  const double across = (detuning - mu_along) * b - (gamma_across + input.rotation_rate) * a +
                        drive_scale * drive.across.imag();
  const double difference = a * a - b * b;

  const Eigen::Vector2d axes =
      dynamics.matrix(device) * Eigen::Vector2d(a, b) + device.drive_gain * dynamics.force;
  OrbitRates rates;
  rates.a = axes[0];
  rates.b = axes[1];
  rates.theta = (a * across - b * along) / difference;
  rates.phi = (a * along - b * across) / difference;
  return rates;
}

AxesRates AveragedModel::axesRates(const Orbit& orbit, const DeviceParameters& device,
                                   const AveragedInput& input) const {
  const AxesDynamics dynamics(*this, orbit, input);
  const Eigen::Vector2d axes(orbit.a, orbit.b);
  AxesRates result;
  result.by_axes = dynamics.matrix(device);
  result.rate = result.by_axes * axes + device.drive_gain * dynamics.force;
  result.by_angles = dynamics.byAngles(axes, device);
  result.by_parameters = dynamics.byParameters(axes);
  return result;
}

RING_GYRO_FLATTEN AxesStep AveragedModel::axesStep(const Orbit& orbit,
                                                   const DeviceParameters& device,
                                                   const AveragedInput& input,
                                                   double duration) const {
  const AxesDynamics dynamics(*this, orbit, input);
  const Eigen::Vector2d axes(orbit.a, orbit.b);
  const Eigen::Matrix2d matrix = dynamics.matrix(device);
  const Eigen::Vector2d force = device.drive_gain * dynamics.force;
  const Eigen::Vector2d middle = axes + 0.5 * duration * (matrix * axes + force);

  AxesStep step;
  step.axes = axes + duration * (matrix * middle + force);
  const Eigen::Matrix2d half = 0.5 * duration * matrix;
  step.by_axes = duration * matrix + duration * matrix * half;
  step.by_axes.diagonal().array() += 1.0;
  step.rate_by_angles = dynamics.byAngles(axes, device);
  // Of the step: h (P(middle) + h/2 M P(axes)), column by column of P, which has only three.
  const auto ofStep = [&](const Eigen::Vector2d& at_middle, const Eigen::Vector2d& at_start) {
    return Eigen::Vector2d(duration * (at_middle + half * at_start));
  };
  const Eigen::Vector2d by_gamma = ofStep(dynamics.byGamma(middle), dynamics.byGamma(axes));
  const Eigen::Vector2d by_mu = ofStep(dynamics.byMu(middle), dynamics.byMu(axes));
  step.by_parameters.col(0) = dynamics.cosine * by_gamma;
  step.by_parameters.col(1) = dynamics.sine * by_gamma;
  step.by_parameters.col(2) = -dynamics.sine * by_mu;
  step.by_parameters.col(3) = dynamics.cosine * by_mu;
  step.by_parameters.col(4) = ofStep(dynamics.force, dynamics.force);
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

}  // namespace ring_gyro
