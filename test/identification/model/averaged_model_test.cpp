#include "ring_gyro/identification/model/averaged_model.h"

#include <gtest/gtest.h>

#include <array>
#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <complex>
#include <limits>
#include <random>
#include <stdexcept>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/demodulation/orbit.h"

namespace cvg {
namespace {

using Complex = std::complex<double>;

constexpr double kFrequency = 14e3;
constexpr double kQuality = 22000.0;
const DeviceParameters kDevice{0.02, 0.03, -30e-6, -40e-6, 1.1e5};

/// Random conditions, wider than in any loop: any angle, any phase, any drive.
class RandomCase {
 public:
  explicit RandomCase(unsigned seed) : engine_(seed) {}

  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  Orbit orbit() {
    return {between(0.5, 1.5), between(-0.3, 0.3), between(-kPi, kPi), between(-kPi, 0.0)};
  }
  DeviceParameters device() {
    return {between(-0.1, 0.1), between(-0.1, 0.1), between(-1e-4, 1e-4), between(-1e-4, 1e-4),
            between(0.5e5, 2e5)};
  }
  Complex phasor(double size) { return {between(-size, size), between(-size, size)}; }
  AveragedInput input() {
    AveragedInput input;
    input.drive = {phasor(3.0), phasor(3.0)};
    input.reference_frequency = kTwoPi * (kFrequency + between(-2.0, 2.0));
    input.pattern_rate = between(-1000.0, 1000.0);
    input.rotation_rate = between(-1.0, 1.0);
    return input;
  }

 private:
  std::mt19937 engine_;
};

/// Largest difference relative to the largest entry of the reference.
template <typename Matrix>
double relativeError(const Matrix& value, const Matrix& reference) {
  return (value - reference).cwiseAbs().maxCoeff() / reference.cwiseAbs().maxCoeff();
}

TEST(AveragedModel, RefusesImpossibleRings) {
  EXPECT_THROW(AveragedModel({0.0, kQuality}), std::invalid_argument);
  EXPECT_THROW(AveragedModel({kFrequency, -1.0}), std::invalid_argument);
  EXPECT_THROW(AveragedModel({std::numeric_limits<double>::quiet_NaN(), kQuality}),
               std::invalid_argument);
  EXPECT_NEAR(AveragedModel({kFrequency, kQuality}).decayRate(), kPi * kFrequency / kQuality,
              1e-15);
}

TEST(AveragedModel, AxesRatesAreThoseOfTheFullModel) {
  const AveragedModel model({kFrequency, kQuality});
  RandomCase random(1);
  for (int k = 0; k < 1000; ++k) {
    const Orbit orbit = random.orbit();
    const DeviceParameters device = random.device();
    const AveragedInput input = random.input();
    const OrbitRates full = model.rates(orbit, device, input);
    const AxesRates axes = model.axesRates(orbit, device, input);
    ASSERT_NEAR(axes.rate[0], full.a, 1e-13);
    ASSERT_NEAR(axes.rate[1], full.b, 1e-13);
  }
}

// a' and b' are linear in the axes and in each parameter: there central differences are exact
// except for rounding. For the angles the third derivative leaves 1e-9.
TEST(AveragedModel, JacobianAgreesWithCentralDifferences) {
  const AveragedModel model({kFrequency, kQuality});
  RandomCase random(2);
  for (int k = 0; k < 1000; ++k) {
    const Orbit orbit = random.orbit();
    const DeviceParameters device = random.device();
    const AveragedInput input = random.input();
    const AxesRates analytic = model.axesRates(orbit, device, input);

    const auto difference = [&](auto&& nudge, double step) {
      Orbit above_orbit = orbit, below_orbit = orbit;
      DeviceParameters above = device, below = device;
      nudge(above_orbit, above, step);
      nudge(below_orbit, below, -step);
      return Eigen::Vector2d((model.axesRates(above_orbit, above, input).rate -
                              model.axesRates(below_orbit, below, input).rate) /
                             (2.0 * step));
    };
    Eigen::Matrix2d by_axes, by_angles;
    by_axes.col(0) = difference([](Orbit& o, DeviceParameters&, double h) { o.a += h; }, 0.1);
    by_axes.col(1) = difference([](Orbit& o, DeviceParameters&, double h) { o.b += h; }, 0.1);
    by_angles.col(0) =
        difference([](Orbit& o, DeviceParameters&, double h) { o.theta += h; }, 1e-4);
    by_angles.col(1) = difference([](Orbit& o, DeviceParameters&, double h) { o.phi += h; }, 1e-4);
    ASSERT_LT(relativeError(analytic.by_axes, by_axes), 1e-12);
    ASSERT_LT(relativeError(analytic.by_angles, by_angles), 1e-7);

    Eigen::Matrix<double, 2, 5> expected;
    expected.col(0) = difference([](Orbit&, DeviceParameters& d, double h) { d.gamma1 += h; }, 0.1);
    expected.col(1) = difference([](Orbit&, DeviceParameters& d, double h) { d.gamma2 += h; }, 0.1);
    expected.col(2) = difference([](Orbit&, DeviceParameters& d, double h) { d.mu1 += h; }, 1e-4);
    expected.col(3) = difference([](Orbit&, DeviceParameters& d, double h) { d.mu2 += h; }, 1e-4);
    expected.col(4) =
        difference([](Orbit&, DeviceParameters& d, double h) { d.drive_gain += h; }, 1e4);
    for (int column = 0; column < 5; ++column) {
      ASSERT_LT(
          relativeError<Eigen::Vector2d>(analytic.by_parameters.col(column), expected.col(column)),
          1e-11)
          << "parameter " << column;
    }
  }
}

TEST(AveragedModel, StepHasTheDerivativesOfItself) {
  const AveragedModel model({kFrequency, kQuality});
  RandomCase random(3);
  const double duration = 1e-3;
  for (int k = 0; k < 300; ++k) {
    const Orbit orbit = random.orbit();
    const DeviceParameters device = random.device();
    const AveragedInput input = random.input();
    const AxesStep step = model.axesStep(orbit, device, input, duration);

    Orbit nudged = orbit;
    nudged.a += 0.1;
    const Eigen::Vector2d by_a =
        (model.axesStep(nudged, device, input, duration).axes - step.axes) / 0.1;
    ASSERT_LT(relativeError<Eigen::Vector2d>(step.by_axes.col(0), by_a), 1e-13);

    const auto byParameter = [&](double DeviceParameters::*parameter, double h) {
      DeviceParameters above = device, below = device;
      above.*parameter += h;
      below.*parameter -= h;
      return Eigen::Vector2d((model.axesStep(orbit, above, input, duration).axes -
                              model.axesStep(orbit, below, input, duration).axes) /
                             (2.0 * h));
    };
    const std::array<std::pair<double DeviceParameters::*, double>, 5> parameters = {
        {{&DeviceParameters::gamma1, 0.1},
         {&DeviceParameters::gamma2, 0.1},
         {&DeviceParameters::mu1, 1e-4},
         {&DeviceParameters::mu2, 1e-4},
         {&DeviceParameters::drive_gain, 1e4}}};
    for (int column = 0; column < 5; ++column) {
      ASSERT_LT(relativeError<Eigen::Vector2d>(
                    step.by_parameters.col(column),
                    byParameter(parameters[column].first, parameters[column].second)),
                1e-9)
          << "parameter " << column;
    }
  }
}

TEST(AveragedModel, StepIsOfSecondOrder) {
  const AveragedModel model({kFrequency, kQuality});
  RandomCase random(4);
  Orbit orbit = random.orbit();
  AveragedInput input = random.input();
  // The angles are constant, so the exact solution is a matrix exponential.
  const auto after = [&](int steps) {
    Orbit now = orbit;
    for (int k = 0; k < steps; ++k) {
      const AxesStep step = model.axesStep(now, kDevice, input, 0.1 / steps);
      now.a = step.axes[0];
      now.b = step.axes[1];
    }
    return Eigen::Vector2d(now.a, now.b);
  };
  const Eigen::Vector2d exact = after(20000);
  const double coarse = (after(10) - exact).norm();
  const double fine = (after(100) - exact).norm();
  EXPECT_NEAR(coarse / fine, 100.0, 3.0);
}

TEST(AveragedModel, DriveTermsAreThePrintedOnesWithTheErrata) {
  // Sustain beta and quadrature alpha of (20) at any phi, against (21)-(24) with corrected signs.
  const AveragedModel model({kFrequency, kQuality});
  RandomCase random(5);
  for (int k = 0; k < 300; ++k) {
    const Orbit orbit = random.orbit();
    const double w = kTwoPi * kFrequency;
    const double beta = random.between(1e-6, 5e-5);
    const double alpha = random.between(-1.0, 1.0);
    const Complex f1(w * beta * orbit.a - alpha * orbit.b, 0.0);
    const Complex f2(0.0, -(w * beta * orbit.b - alpha * orbit.a));
    const double c = std::cos(orbit.theta), s = std::sin(orbit.theta);
    AveragedInput driven;
    driven.reference_frequency = w;
    driven.drive = {c * f1 - s * f2, s * f1 + c * f2};
    AveragedInput quiet = driven;
    quiet.drive.setZero();

    const OrbitRates with = model.rates(orbit, kDevice, driven);
    const OrbitRates without = model.rates(orbit, kDevice, quiet);
    const double ks = kDevice.drive_gain;
    const double sine = std::sin(orbit.phi), cosine = std::cos(orbit.phi);
    EXPECT_NEAR(with.a - without.a, -ks * (orbit.a * beta / 2 - orbit.b * alpha / (2 * w)) * sine,
                1e-12);
    EXPECT_NEAR(with.b - without.b, -ks * (orbit.b * beta / 2 - orbit.a * alpha / (2 * w)) * sine,
                1e-12);
    EXPECT_NEAR(with.theta - without.theta, ks * alpha * cosine / (2 * w), 1e-12);
    EXPECT_NEAR(with.phi - without.phi, -ks * beta * cosine / 2, 1e-12);
  }
}

TEST(AveragedModel, SteeringTurnsThePatternWithItsSign) {
  const AveragedModel model({kFrequency, kQuality});
  const DeviceParameters ideal{0.0, 0.0, 0.0, 0.0, kDevice.drive_gain};
  const double rate = 0.2;
  const double w = kTwoPi * kFrequency;
  const Orbit orbit{1.1, 0.02, 0.7, -kPi / 2};
  const double c = std::cos(orbit.theta), s = std::sin(orbit.theta);
  const Complex v1(w * orbit.a, 0.0), v2(0.0, -w * orbit.b);
  const Eigen::Vector2cd velocity(c * v1 - s * v2, s * v1 + c * v2);
  AveragedInput steered;
  steered.reference_frequency = w;
  steered.drive = 2.0 * rate / ideal.drive_gain * Eigen::Vector2cd(velocity.y(), -velocity.x());
  AveragedInput rotated;
  rotated.reference_frequency = w;
  rotated.rotation_rate = rate;

  const OrbitRates by_drive = model.rates(orbit, ideal, steered);
  const OrbitRates by_rotation = model.rates(orbit, ideal, rotated);
  EXPECT_NEAR(by_drive.theta, -rate, 1e-13);
  EXPECT_NEAR(by_rotation.theta, -rate, 1e-13);
  EXPECT_NEAR(by_drive.a, by_rotation.a, 1e-13);
  EXPECT_NEAR(by_drive.b, by_rotation.b, 1e-13);
  EXPECT_NEAR(by_drive.phi, by_rotation.phi, 1e-13);
}

// ---- Against the two-mode equations in time ---------------------------------------------------

/// u'' + C u' + K u = ks Re[F e^{i psi}] of section 3, psi' = w + chirp t, written from (10) with
/// its errata, independent of the averaged model.
class TimeDomain {
 public:
  using State = std::array<double, 5>;  // x, y, x', y', psi

  TimeDomain(const DeviceParameters& device, const AveragedInput& input)
      : device_(device), input_(input) {}

  void operator()(const State& u, State& rate, double t) const {
    const double w0 = kTwoPi * kFrequency;
    const double d = w0 / kQuality;
    const Complex wheel = std::polar(1.0, u[4]);
    rate[0] = u[2];
    rate[1] = u[3];
    rate[2] = device_.drive_gain * (input_.drive.x() * wheel).real() +
              2.0 * input_.rotation_rate * u[3] -
              d * ((1.0 + device_.gamma1) * u[2] + device_.gamma2 * u[3]) -
              w0 * w0 * ((1.0 + device_.mu1) * u[0] + device_.mu2 * u[1]);
    rate[3] = device_.drive_gain * (input_.drive.y() * wheel).real() -
              2.0 * input_.rotation_rate * u[2] -
              d * (device_.gamma2 * u[2] + (1.0 - device_.gamma1) * u[3]) -
              w0 * w0 * (device_.mu2 * u[0] + (1.0 - device_.mu1) * u[1]);
    rate[4] = input_.reference_frequency + chirp * t;
  }

  double chirp = 0.0;

 private:
  DeviceParameters device_;
  AveragedInput input_;
};

/// Orbits demodulated from the motion, at two moments.
struct DemodulatedPair {
  Orbit begin;
  Orbit end;
};

/// Integrates `cycles` whole cycles, with steps whose error is far below the asserted tolerance,
/// and demodulates over `window` of them at each end, with a window of very low side lobes.
template <typename Plant>
DemodulatedPair simulate(const Plant& plant, const Orbit& start, double w, int cycles, int window) {
  const int per_cycle = 64;
  const double h = kTwoPi / w / per_cycle;
  const Eigen::Vector2cd envelope = envelopeFromOrbit(start);
  TimeDomain::State u = {envelope.x().real(), envelope.y().real(),
                         (Complex(0.0, w) * envelope.x()).real(),
                         (Complex(0.0, w) * envelope.y()).real(), 0.0};
  boost::numeric::odeint::runge_kutta_fehlberg78<TimeDomain::State> stepper;
  const int samples = window * per_cycle;
  const int total = cycles * per_cycle + samples;
  Eigen::Vector2cd first = Eigen::Vector2cd::Zero(), last = Eigen::Vector2cd::Zero();
  double weight_sum = 0.0;
  for (int n = 0; n <= total; ++n) {
    const Complex wheel = 2.0 * std::polar(1.0, -u[4]);
    const auto weight = [&](int k) {
      return k < 0 || k > samples ? 0.0 : std::pow(std::sin(kPi * k / samples), 6);
    };
    first += weight(n) * wheel * Eigen::Vector2cd(u[0], u[1]);
    last += weight(n - cycles * per_cycle) * wheel * Eigen::Vector2cd(u[0], u[1]);
    weight_sum += weight(n);
    stepper.do_step(plant, u, n * h, h);
  }
  return {orbitFromEnvelope(first / weight_sum), orbitFromEnvelope(last / weight_sum)};
}

Eigen::Vector4d change(const Orbit& from, const Orbit& to) {
  return {to.a - from.a, to.b - from.b, wrapToPi(to.theta - from.theta),
          wrapToPi(to.phi - from.phi)};
}

// In 300 cycles, 21 ms, the orbit changes by a few hundredths. The first order leaves out a part of
// this change, the slow rates over 2 w: 1e-4 at these conditions.
TEST(AveragedModel, RatesAgreeWithTheTimeDomainAtAnyPhase) {
  const AveragedModel model({kFrequency, kQuality});
  RandomCase random(6);
  for (int k = 0; k < 12; ++k) {
    const Orbit start = random.orbit();
    const DeviceParameters device = random.device();
    AveragedInput input = random.input();
    input.pattern_rate = 0.0;
    const int cycles = 300;
    const DemodulatedPair truth =
        simulate(TimeDomain(device, input), start, input.reference_frequency, cycles, 20);
    const Orbit predicted = model.integrate(truth.begin, device, input,
                                            kTwoPi * cycles / input.reference_frequency, 300);
    const Eigen::Vector4d moved = change(truth.begin, truth.end);
    const Eigen::Vector4d error = change(truth.end, predicted);
    EXPECT_LT(error.cwiseAbs().maxCoeff(), 1e-4 * moved.cwiseAbs().maxCoeff())
        << "case " << k << ": moved " << moved.transpose() << ", error " << error.transpose();
  }
}

// Quadrature and sustain away from -90 deg: with the printed signs of (23)(24) theta and phi move
// in the wrong direction.
TEST(AveragedModel, TimeDomainDecidesTheSignsOf23And24) {
  // An ideal ring: with mismatch the change of b would change theta and phi too.
  const DeviceParameters ideal{0.0, 0.0, 0.0, 0.0, kDevice.drive_gain};
  const double w = kTwoPi * kFrequency;
  const double ks = ideal.drive_gain;
  const double alpha = 0.5, beta = 2e-5;
  const Orbit start{1.0, 0.2, 0.4, -kPi / 2 + 0.6};
  const double c = std::cos(start.theta), s = std::sin(start.theta);
  const Complex f1(w * beta * start.a - alpha * start.b, 0.0);
  const Complex f2(0.0, -(w * beta * start.b - alpha * start.a));
  AveragedInput driven;
  driven.reference_frequency = w;
  driven.drive = {c * f1 - s * f2, s * f1 + c * f2};
  AveragedInput quiet = driven;
  quiet.drive.setZero();
  const int cycles = 40;
  const double time = cycles / kFrequency;
  const DemodulatedPair with = simulate(TimeDomain(ideal, driven), start, w, cycles, 20);
  const DemodulatedPair without = simulate(TimeDomain(ideal, quiet), start, w, cycles, 20);
  const Eigen::Vector4d effect =
      (change(with.begin, with.end) - change(without.begin, without.end)) / time;
  const double cosine = std::cos(start.phi);
  EXPECT_NEAR(effect[2], ks * alpha * cosine / (2 * w), 0.01 * ks * alpha * cosine / (2 * w));
  EXPECT_NEAR(effect[3], -ks * beta * cosine / 2, 0.01 * ks * beta * cosine / 2);
}

// A reference whose frequency rises changes phi, but not the size of the orbit.
TEST(AveragedModel, ReferenceThatRunsAwayDoesNotScaleTheOrbit) {
  const DeviceParameters ideal{0.0, 0.0, 0.0, 0.0, kDevice.drive_gain};
  const double w = kTwoPi * kFrequency;
  const double chirp = 3000.0;
  AveragedInput quiet;
  quiet.reference_frequency = w;
  // The reference passes the resonance half-way: the window loses the same by detuning at both
  // ends.
  AveragedInput early = quiet;
  early.reference_frequency = w - chirp * 60 / kFrequency;
  TimeDomain steady(ideal, quiet), chirped(ideal, early);
  chirped.chirp = chirp;
  const Orbit start{1.0, 0.0, 0.3, -kPi / 2};
  const DemodulatedPair reference = simulate(steady, start, w, 100, 20);
  const DemodulatedPair moving = simulate(chirped, start, w, 100, 20);
  const double shrinks =
      (moving.end.a / moving.begin.a) / (reference.end.a / reference.begin.a) - 1.0;
  const double as_if_followed = -0.5 * chirp / w * 100 / kFrequency;
  EXPECT_LT(std::abs(shrinks), 0.01 * std::abs(as_if_followed));
}

// A pattern turns in a ring with a frequency split while its quadrature is nulled. The frequency
// follows the angle, and an orbit whose frequency rises at w' shrinks at the relative rate
// w' / (2 w). Half of this comes from the turning pattern, half from the changing drive.
TEST(AveragedModel, OrbitShrinksAsTheVibrationSpeedsUp) {
  const double w0 = kTwoPi * kFrequency;
  const double mu = 2e-3;
  const double turning = 20.0;  // [rad/s]
  const double middle = 60 / kFrequency;
  const auto angle = [&](double t) { return 0.3 - turning * (t - middle); };
  const auto plant = [&](const TimeDomain::State& u, TimeDomain::State& rate, double t) {
    const double c = std::cos(angle(t)), s = std::sin(angle(t));
    // A force across the pattern, in phase with the displacement along it: an ideal quadrature
    // loop.
    const double across = -w0 * w0 * mu * std::sin(2.0 * angle(t)) * (c * u[0] + s * u[1]);
    const double d = w0 / kQuality;
    rate[0] = u[2];
    rate[1] = u[3];
    rate[2] = 2.0 * turning * u[3] - d * u[2] - w0 * w0 * (1.0 + mu) * u[0] - s * across;
    rate[3] = -2.0 * turning * u[2] - d * u[3] - w0 * w0 * (1.0 - mu) * u[1] + c * across;
    rate[4] = w0 * (1.0 + 0.5 * mu * std::cos(2.0 * angle(middle)));
  };
  const DemodulatedPair orbits = simulate(plant, {1.0, 0.0, angle(0.0), -kPi / 2}, w0, 100, 20);
  const double time = 100 / kFrequency;
  ASSERT_NEAR(orbits.end.theta - orbits.begin.theta, -turning * time, 1e-4);
  const double chirp = w0 * mu * std::sin(2.0 * angle(middle)) * turning;
  const double decay = AveragedModel({kFrequency, kQuality}).decayRate();
  const double shrinks = std::log(orbits.end.a / orbits.begin.a) + decay * time;
  EXPECT_NEAR(shrinks, -0.5 * chirp / w0 * time, 0.01 * 0.5 * chirp / w0 * time);

  AveragedInput input;
  input.reference_frequency = w0;
  input.pattern_rate = -turning;
  const DeviceParameters split{0.0, 0.0, mu, 0.0, kDevice.drive_gain};
  const auto driveAt = [&](double t) {
    const Complex across =
        -w0 * w0 * mu * std::sin(2.0 * angle(t)) / split.drive_gain * std::polar(1.0, -kPi / 2);
    return Eigen::Vector2cd(-std::sin(angle(t)) * across, std::cos(angle(t)) * across);
  };
  const double step = 1e-6;
  input.drive = driveAt(middle) + Complex(0.0, 0.5 / (w0 * step)) *
                                      (driveAt(middle + 0.5 * step) - driveAt(middle - 0.5 * step));
  const AxesRates rates = AveragedModel({kFrequency, kQuality})
                              .axesRates({1.0, 0.0, angle(middle), -kPi / 2}, split, input);
  EXPECT_NEAR(rates.rate[0] + decay, -0.5 * chirp / w0, 0.005 * chirp / w0);
}

// From rest, without damping, a drive that starts at the phase psi moves the envelope along a
// straight line, which is shifted by ks / (4 w^2) (F - F* e^{-2 i psi}).
TEST(AveragedModel, DriveThatStepsMovesTheEnvelope) {
  const double w = kTwoPi * kFrequency;
  const Eigen::Vector2cd drive(Complex(3.0, 1.0), Complex(-1.0, 2.0));
  for (const double phase : {0.0, 0.7, 2.0}) {
    SCOPED_TRACE(phase);
    const auto plant = [&](const TimeDomain::State& u, TimeDomain::State& rate, double) {
      const Complex wheel = std::polar(1.0, u[4] + phase);
      rate[0] = u[2];
      rate[1] = u[3];
      rate[2] = kDevice.drive_gain * (drive.x() * wheel).real() - w * w * u[0];
      rate[3] = kDevice.drive_gain * (drive.y() * wheel).real() - w * w * u[1];
      rate[4] = w;
    };
    const DemodulatedPair orbits = simulate(plant, {0.0, 0.0, 0.0, 0.0}, w, 100, 20);
    // The demodulator counts from the step, the NCO from `phase` before it.
    const Eigen::Vector2cd envelope = envelopeFromOrbit(orbits.end) * std::polar(1.0, -phase);
    const double time = 110 / kFrequency;
    const Eigen::Vector2cd first_order = Complex(0.0, -0.5 * kDevice.drive_gain / w * time) * drive;
    const double duration = 1e-3;
    const Eigen::Vector2cd extra = driveStep(Eigen::Vector2cd::Zero(), drive, phase, w, duration);
    const Eigen::Vector2cd predicted =
        Complex(0.0, -0.5 * kDevice.drive_gain / w * duration) * extra;
    const double size = kDevice.drive_gain / (4.0 * w * w) * drive.norm();
    EXPECT_LT((envelope - first_order - predicted).norm(), 1e-3 * size);
    EXPECT_GT((envelope - first_order).norm(), 0.1 * size);
  }
}

TEST(AveragedModel, IntegrateConvergesWithTheFourthPowerOfItsStep) {
  const AveragedModel model({kFrequency, kQuality});
  AveragedInput input;
  input.reference_frequency = kTwoPi * kFrequency;
  input.rotation_rate = 5.0;
  const Orbit start{1.0, 0.1, 0.3, -1.4};
  const Orbit exact = model.integrate(start, kDevice, input, 1.0, 4000);
  const double coarse = change(exact, model.integrate(start, kDevice, input, 1.0, 20)).norm();
  const double fine = change(exact, model.integrate(start, kDevice, input, 1.0, 40)).norm();
  EXPECT_NEAR(coarse / fine, 16.0, 3.0);
}

}  // namespace
}  // namespace cvg
