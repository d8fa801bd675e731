#include "ring_gyro/resonator/ring_resonator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

#include "resonator/reference_solution.h"
#include "ring_gyro/resonator/sampled_resonator.h"

namespace cvg {
namespace {

using Complex = std::complex<double>;
using Real = ReferenceSolution::Real;

ResonatorParameters paperRing() {
  ResonatorParameters p;
  p.natural_frequency = 14000.0;
  p.quality_factor = 22000.0;
  p.gamma1 = 0.02;
  p.gamma2 = 0.03;
  p.mu1 = -30e-6;
  p.mu2 = -40e-6;
  p.drive_gain = 1.1e5;
  p.angular_gain = 0.37;
  return p;
}

struct BlockDrive {
  Eigen::Vector2cd envelope;
  double phase;
  double frequency;
  double rate;
};

BlockDrive randomDrive(std::mt19937& random, double natural_frequency) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  return {{Complex(6.0 * unit(random), 6.0 * unit(random)),
           Complex(6.0 * unit(random), 6.0 * unit(random))},
          kPi * unit(random),
          kTwoPi * (natural_frequency + 5.0 * unit(random)),
          2.0 * unit(random)};
}

// Error against the solver when drive, frequency and rate change every millisecond; a drive f acts
// as f + quadratic f^2.
double blockError(double quadratic, int blocks) {
  const ResonatorParameters p = paperRing();
  RingResonator ring(p);
  const ReferenceSolution solver(p);
  std::mt19937 random(1);
  const double duration = 1e-3;
  const double w0 = p.angularFrequency();
  ring.setState({1.0, 0.2, -0.1 * w0, 0.3 * w0});
  ReferenceSolution::State reference = {1.0L, 0.2L, Real(-0.1 * w0), Real(0.3 * w0)};
  double largest = 0.0;
  for (int block = 0; block < blocks; ++block) {
    const BlockDrive drive = randomDrive(random, p.natural_frequency);
    DriveForce acting = drive.envelope;
    acting.constant = 0.5 * quadratic * drive.envelope.cwiseAbs2();
    acting.second = 0.5 * quadratic * drive.envelope.cwiseProduct(drive.envelope);
    ring.setConditions(drive.rate, 0.0);
    ring.propagate(acting, drive.phase, drive.frequency, duration);
    const auto force = [&](int axis, Real t) {
      const Real turn = drive.phase + Real(drive.frequency) * t;
      const Real volts = Real(drive.envelope[axis].real()) * std::cos(turn) -
                         Real(drive.envelope[axis].imag()) * std::sin(turn);
      return volts + Real(quadratic) * volts * volts;
    };
    solver.integrate(
        reference, 0.0L, Real(duration), [&](Real t) { return force(0, t); },
        [&](Real t) { return force(1, t); }, [&](Real) { return Real(drive.rate); });
    largest = std::max(largest, relativeError(reference, ring.state().data(), w0, 1.0));
  }
  return largest;
}

TEST(RingResonator, IsExactAgainstAnOdeSolver) {
  const double error = blockError(0.0, 1000);
  std::printf("[figure] plant against ODE reference, 1 s, relative: %.2e (must 1e-9, aim 1e-11)\n",
              error);
  EXPECT_LT(error, 1e-11);
}

TEST(RingResonator, IsExactWithTheSquareOfTheDrive) {
  const double error = blockError(0.02, 300);
  std::printf("[figure] with the square law of a 25 V bias, 0.3 s, relative: %.2e (must 1e-11)\n",
              error);
  EXPECT_LT(error, 1e-11);
}

TEST(RingResonator, SamplesOfABlockLieOnItsMotion) {
  const ResonatorParameters p = paperRing();
  RingResonator whole(p);
  RingResonator parts(p);
  std::mt19937 random(2);
  const BlockDrive drive = randomDrive(random, p.natural_frequency);
  const Eigen::Vector4d start(0.3, -0.8, 2e4, 5e4);
  whole.setState(start);
  parts.setState(start);
  const double duration = 1e-3;
  const BlockMotion motion =
      whole.propagate(drive.envelope, drive.phase, drive.frequency, duration);
  const int samples = 200;
  for (int j = 0; j < samples; ++j) {
    const double share = static_cast<double>(j) / samples;
    Eigen::Vector2cd value = Eigen::Vector2cd::Zero();
    const PhasorSeries& series = motion.series;
    for (int k = series.terms - 1; k >= 0; --k) {
      const Eigen::Vector2cd coefficient(Complex(series.x_real[k], series.x_imaginary[k]),
                                         Complex(series.y_real[k], series.y_imaginary[k]));
      value = value * share + coefficient;
    }
    value *= std::polar(1.0, motion.reference_frequency * share * duration);
    ASSERT_NEAR(value[0].real(), parts.state()[0], 2e-12);
    ASSERT_NEAR(value[1].real(), parts.state()[1], 2e-12);
    parts.propagate(drive.envelope, drive.phase + drive.frequency * share * duration,
                    drive.frequency, duration / samples);
  }
}

TEST(RingResonator, DecaysAtItsDampingRatio) {
  ResonatorParameters p = paperRing();
  p.gamma1 = p.gamma2 = p.mu1 = p.mu2 = 0.0;
  RingResonator ring(p);
  ring.setState({1.0, 0.0, 0.0, 0.0});
  for (int block = 0; block < 500; ++block) {
    ring.propagate(DriveForce(), 0.0, p.angularFrequency(), 1e-3);
  }
  EXPECT_NEAR(ring.freeEnvelope(ring.state()).norm(), std::exp(-0.5 * p.decayRate()), 1e-9);
}

TEST(RingResonator, SteadyResponseHasTheGainOfEquation34) {
  ResonatorParameters p = paperRing();
  p.gamma1 = p.gamma2 = p.mu1 = p.mu2 = 0.0;
  const RingResonator ring(p);
  const double w0 = p.angularFrequency();
  const Eigen::Vector2cd response = ring.steadyResponse({1.0, 0.0}, w0);
  EXPECT_NEAR(std::abs(response[0]), p.drive_gain * p.quality_factor / (w0 * w0), 1e-12);
  EXPECT_NEAR(std::arg(response[0]), -0.5 * kPi, 1e-12);
}

TEST(RingResonator, RefusesAReferenceFarOffTheResonance) {
  RingResonator ring(paperRing());
  EXPECT_THROW(ring.propagate(Eigen::Vector2cd(1.0, 0.0), 0.0, kTwoPi * 4000.0, 1e-3),
               std::domain_error);
}

// What the block solution leaves out, against the solver, over a second: `amplitude` [rad/s] and
// `frequency` [Hz] of the rate.
double sampledError(const ResonatorParameters& p, double gap_cubic, double amplitude,
                    double frequency) {
  const Real h = 5e-6;
  const double w0 = p.angularFrequency();
  RingResonator ring(p);
  SampledResonator sampled(p, gap_cubic, 5e-6);
  sampled.setLinear(ring);
  const ReferenceSolution solver(p, 1e-15L, gap_cubic);
  Eigen::Vector4d state(1.0, 0.1, 0.0, 0.2 * w0);
  ReferenceSolution::State reference = {1.0L, 0.1L, 0.0L, Real(0.2 * w0)};
  SampleDrive drive;
  const double reference_frequency = w0 + 3.0;
  drive.force = Eigen::Vector2cd(Complex(3.0, 0.5), Complex(-1.0, 2.0));
  drive.forced = ring.steadyMotion(drive.force, reference_frequency);
  const auto rate = [&](double t) { return amplitude * std::sin(kTwoPi * frequency * t); };
  double largest = 0.0;
  for (int j = 0; j < 200000; ++j) {
    const double t = static_cast<double>(h * j);
    const Real turn = 2.0L * std::acos(-1.0L);
    const Real phase = std::fmod(Real(reference_frequency) * h * j, turn);
    drive.phase = static_cast<double>(phase);
    drive.next_phase = static_cast<double>(phase + Real(reference_frequency) * h);
    state = sampled.step(state, drive, t, rate);
    if ((j + 1) % 20000 != 0) continue;
    const auto force = [&](int axis, Real at) {
      const Real turn = Real(reference_frequency) * at;
      return Real(drive.force.fundamental[axis].real()) * std::cos(turn) -
             Real(drive.force.fundamental[axis].imag()) * std::sin(turn);
    };
    solver.integrate(
        reference, Real(h) * (j - 19999), Real(h) * (j + 1), [&](Real at) { return force(0, at); },
        [&](Real at) { return force(1, at); },
        [&](Real at) {
          return Real(amplitude) * std::sin(2.0L * std::acos(-1.0L) * frequency * at);
        });
    largest = std::max(largest, relativeError(reference, state.data(), w0, 1.0));
  }
  return largest;
}

// Held drives, new ones at each sample, by `move(state, x, y)` of a sample, for 50 ms.
template <typename Move>
double heldError(const ResonatorParameters& p, double gap_cubic, const Move& move) {
  const Real h = 5e-6;
  const double w0 = p.angularFrequency();
  const ReferenceSolution solver(p, 1e-15L, gap_cubic);
  Eigen::Vector4d state(1.0, 0.1, 0.0, 0.2 * w0);
  ReferenceSolution::State reference = {1.0L, 0.1L, 0.0L, Real(0.2 * w0)};
  double largest = 0.0;
  for (int j = 0; j < 10000; ++j) {
    const Eigen::Vector2d value(3.0 * std::cos(0.44 * j), 2.0 * std::sin(0.44 * j) + 0.1);
    move(state, value);
    solver.integrate(
        reference, Real(h) * j, Real(h) * (j + 1), [&](Real) { return Real(value[0]); },
        [&](Real) { return Real(value[1]); }, [](Real) { return 0.3L; });
    largest = std::max(largest, relativeError(reference, state.data(), w0, 1.0));
  }
  return largest;
}

TEST(SampledResonator, HeldDriveIsExact) {
  const ResonatorParameters p = paperRing();
  RingResonator ring(p);
  ring.setConditions(0.3, 0.0);
  SampledResonator sampled(p, 0.0, 5e-6);
  sampled.setLinear(ring);
  ASSERT_TRUE(sampled.isLinear());
  const double error = heldError(p, 0.0, [&](Eigen::Vector4d& state, const Eigen::Vector2d& value) {
    const Eigen::Vector4d before = state;
    double x = 0.0;
    double y = 0.0;
    sampled.moveHeld(state, &value[0], &value[1], 1, {0.0, 0.5 * kPi}, &x, &y);
    ASSERT_NEAR(x, before[0], 1e-15);
    ASSERT_NEAR(y, -before[3] / p.angularFrequency(), 1e-15);
  });
  std::printf("[figure] held drive against ODE, 50 ms: %.2e (must 1e-11)\n", error);
  EXPECT_LT(error, 1e-11);
}

TEST(SampledResonator, HeldDriveInAGapThatCloses) {
  const ResonatorParameters p = paperRing();
  RingResonator ring(p);
  ring.setConditions(0.3, 0.0);
  SampledResonator sampled(p, 0.06, 5e-6);
  sampled.setLinear(ring);
  ASSERT_FALSE(sampled.isLinear());
  SampleDrive drive;
  drive.held = true;
  const double integrated =
      heldError(p, 0.06, [&](Eigen::Vector4d& state, const Eigen::Vector2d& value) {
        drive.value = value;
        state = sampled.step(state, drive, 0.0, [](double) { return 0.0; });
      });
  ASSERT_TRUE(sampled.canMoveHeld());
  const double moved =
      heldError(p, 0.06, [&](Eigen::Vector4d& state, const Eigen::Vector2d& value) {
        double x = 0.0;
        double y = 0.0;
        sampled.moveHeld(state, &value[0], &value[1], 1, {0.0, 0.0}, &x, &y);
      });
  std::printf(
      "[figure] held drive in a gap that closes against ODE, 50 ms: integrated %.2e, by nodes %.2e "
      "(must 1e-8)\n",
      integrated, moved);
  EXPECT_LT(integrated, 1e-8);
  EXPECT_LT(moved, 1e-8);
}

TEST(SampledResonator, DriveInAGapThatCloses) {
  const double error = sampledError(paperRing(), 0.06, 0.0, 0.0);
  std::printf("[figure] gap that closes by 6 %% at 1 V against ODE, 1 s: %.2e (must 1e-7)\n",
              error);
  EXPECT_LT(error, 1e-7);
}

TEST(SampledResonator, RateThatVariesWithinABlock) {
  const double error = sampledError(paperRing(), 0.0, 5.0, 50.0);
  std::printf("[figure] rate varying within a block against ODE, 1 s: %.2e (must 1e-7)\n", error);
  EXPECT_LT(error, 1e-7);
}

TEST(SampledResonator, CubicStiffness) {
  ResonatorParameters p = paperRing();
  p.cubic_stiffness = 2e-4;  // shifts the frequency by about 1 Hz at 1 V
  const double error = sampledError(p, 0.0, 0.0, 0.0);
  std::printf("[figure] cubic stiffness against ODE, 1 s: %.2e (must 1e-7)\n", error);
  EXPECT_LT(error, 1e-7);
}

}  // namespace
}  // namespace cvg
