#include "ring_gyro/control/control_loops.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/demodulation/orbit.h"
#include "ring_gyro/resonator/plant_simulator.h"
#include "ring_gyro/signals/calibration_command.h"

namespace cvg {
namespace {

constexpr std::int64_t kStart = 1000000000;

struct LoopSetup {
  PlantParameters plant;
  DeviceKnowledge device;
  ControlParameters control;
  ConverterParameters converter;
  Corrections corrections;

  LoopSetup() {
    ResonatorParameters& r = plant.resonator;
    r.natural_frequency = device.natural_frequency = 14000.0;
    r.quality_factor = device.quality_factor = 22000.0;
    r.drive_gain = device.drive_gain = 1.1e5;
    r.gamma1 = 0.02;
    r.gamma2 = 0.03;
    r.mu1 = -30e-6;
    r.mu2 = -40e-6;
    control.frequency_offset = 5.0;
  }
  // No mismatch: with it the angle swings about its mean rate.
  void makeIdeal() {
    ResonatorParameters& r = plant.resonator;
    r.gamma1 = r.gamma2 = r.mu1 = r.mu2 = 0.0;
  }
};

// Plant and loops in lockstep.
class Loop {
 public:
  explicit Loop(const LoopSetup& setup)
      : plant_(setup.plant, setup.converter, 1, 1, kStart),
        loops_(setup.device, setup.control, {}, setup.converter, setup.corrections) {
    block_ = plant_.start();
  }
  const LoopOutput& step() {
    const LoopOutput& output = loops_.process(block_);
    block_ = plant_.step(output.command);
    return output;
  }
  double time() const { return 1e-9 * static_cast<double>(block_.stamp.end_ns - kStart); }
  // Time at which all loops were locked; empty when they are not within `limit` [s].
  std::optional<double> lockTime(double limit) {
    while (time() < limit) {
      if (step().elements.status.locked()) return time();
    }
    return {};
  }
  DisplacementBlock& block() { return block_; }
  ControlLoops& loops() { return loops_; }
  Orbit trueOrbit() const { return orbitFromEnvelope(plant_.truth().envelope); }

 private:
  PlantSimulator plant_;
  ControlLoops loops_;
  DisplacementBlock block_;
};

/// Every kind of parameter that it is made from, with the key in what it says.
TEST(ControlLoops, RefuseWhatTheyCannotUse) {
  const auto refused = [](const std::string& key, const std::function<void(LoopSetup&)>& change) {
    LoopSetup setup;
    DemodulationParameters demodulation;
    change(setup);
    try {
      ControlLoops loops(setup.device, setup.control, demodulation, setup.converter,
                         setup.corrections);
      ADD_FAILURE() << key;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(key), std::string::npos) << error.what();
    }
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refused("device/natural_frequency", [](auto& s) { s.device.natural_frequency = 0.0; });
  refused("device/quality_factor", [=](auto& s) { s.device.quality_factor = nan; });
  refused("device/drive_gain", [](auto& s) { s.device.drive_gain = -1.0; });
  refused("control/amplitude", [](auto& s) { s.control.amplitude = 0.0; });
  refused("control/drive_limit", [](auto& s) { s.control.drive_limit = -10.0; });
  refused("control/learning_rate", [=](auto& s) { s.control.learning_rate = nan; });
  refused("bandwidth", [](auto& s) { s.control.phase_loop.bandwidth = 0.0; });
  refused("damping", [=](auto& s) { s.control.angle_tracker.damping = nan; });
  refused("converter/block_samples", [](auto& s) { s.converter.block_samples = 0; });
  refused("calibration/pickoff_cubic", [=](auto& s) { s.corrections.pickoff_cubic = nan; });
  refused("calibration/drift_cosine", [=](auto& s) { s.corrections.drift.cosine = {nan}; });
  refused("compensation and calibration_run",
          [](auto& s) { s.control.compensation = s.control.calibration_run = true; });
}

TEST(ControlLoops, RingUpAndLockFromRest) {
  Loop loop{LoopSetup()};
  const std::optional<double> time = loop.lockTime(2.0);
  ASSERT_TRUE(time.has_value());
  std::printf("[figure] ring-up from rest to all loops locked: %.3f s (must 2, aim 1)\n", *time);
  EXPECT_LT(*time, 1.0);
}

TEST(ControlLoops, LockOverFrequencyOffsetsAndPatternAngles) {
  for (double offset = -20.0; offset <= 20.0; offset += 4.0) {
    for (double sense_phase : {-0.05, 0.0, 0.05}) {
      LoopSetup setup;
      setup.control.frequency_offset = offset;
      setup.plant.sense.axes.phase_delay = sense_phase;
      EXPECT_TRUE(Loop(setup).lockTime(1.0).has_value())
          << "NCO " << offset << " Hz off, sense phase " << sense_phase;
    }
  }
}

TEST(ControlLoops, HoldPhaseAndQuadratureAtTwelveDegreesPerSecond) {
  for (const double noise : {0.0, 5e-6}) {
    LoopSetup setup;
    setup.plant.sense.noise_density = noise;
    setup.control.virtual_rate = toRadians(12.0);
    Loop loop(setup);
    ASSERT_TRUE(loop.lockTime(1.0).has_value());
    while (loop.time() < 1.0) loop.step();
    double phase_error = 0.0;
    double quadrature = 0.0;
    while (loop.time() < 31.0) {
      loop.step();
      const Orbit orbit = loop.trueOrbit();
      phase_error = std::max(phase_error, std::abs(orbit.phi + 0.5 * kPi));
      quadrature = std::max(quadrature, std::abs(orbit.b) / orbit.a);
    }
    std::printf(
        "[figure] noise %.0e: phi error %.4f deg (must 0.05 with, aim 0.01 without noise), "
        "|b|/a %.2e (must 1e-3 with, aim 1.5e-4 without noise)\n",
        noise, toDegrees(phase_error), quadrature);
    EXPECT_LT(toDegrees(phase_error), noise > 0.0 ? 0.05 : 0.01);
    EXPECT_LT(quadrature, noise > 0.0 ? 1e-3 : 1.5e-4);
  }
}

// Without learning the rest of b turns the pattern by b mu w0: 9e-4 of the rate here.
TEST(ControlLoops, LearnTheSwingOfQuadratureAndFrequency) {
  LoopSetup setup;
  setup.control.virtual_rate = toRadians(12.0);
  Loop loop(setup);
  ASSERT_TRUE(loop.lockTime(1.0).has_value());
  while (loop.time() < 31.0) loop.step();
  double phase_error = 0.0;
  double quadrature = 0.0;
  while (loop.time() < 46.0) {
    loop.step();
    const Orbit orbit = loop.trueOrbit();
    phase_error = std::max(phase_error, std::abs(orbit.phi + 0.5 * kPi));
    quadrature = std::max(quadrature, std::abs(orbit.b) / orbit.a);
  }
  std::printf("[figure] noise off, swing learnt: phi error %.1e deg, |b|/a %.1e\n",
              toDegrees(phase_error), quadrature);
  EXPECT_LT(toDegrees(phase_error), 1e-3);
  EXPECT_LT(quadrature, 1e-5);
}

TEST(ControlLoops, SteerAtTheVirtualRateBothWays) {
  for (const double rate : {toRadians(12.0), -toRadians(40.0)}) {
    LoopSetup setup;
    setup.makeIdeal();
    setup.plant.resonator.natural_frequency = setup.device.natural_frequency = 14195.0;
    setup.control.virtual_rate = rate;
    Loop loop(setup);
    ASSERT_TRUE(loop.lockTime(1.0).has_value());
    while (loop.time() < 1.5) loop.step();
    const double begin = loop.step().elements.orbit.theta;
    for (int n = 0; n < 2000; ++n) loop.step();
    const double turned = loop.loops().process(loop.block()).elements.orbit.theta - begin;
    EXPECT_NEAR(turned / (2.001 * -rate), 1.0, 1e-6);
  }
}

TEST(ControlLoops, CompensateAKnownMismatchFromTheStart) {
  LoopSetup setup;
  setup.plant.resonator.mu1 = setup.plant.resonator.mu2 = 0.0;
  setup.control.virtual_rate = toRadians(12.0);
  const auto spread = [](const LoopSetup& with) {
    Loop loop(with);
    EXPECT_TRUE(loop.lockTime(1.0).has_value());
    while (loop.time() < 1.5) loop.step();
    double lowest = 1e9;
    double highest = -1e9;
    while (loop.time() < 17.0) {
      const double rate = toDegrees(loop.step().elements.theta_rate);
      lowest = std::min(lowest, rate);
      highest = std::max(highest, rate);
    }
    return highest - lowest;
  };
  EXPECT_NEAR(spread(setup), 8.26, 0.1);  // 2 xi0 w0 |gamma|
  setup.corrections.gamma1 = 0.02;
  setup.corrections.gamma2 = 0.03;
  EXPECT_LT(spread(setup), 0.01);
}

// At 14.000 kHz a block is a whole number of cycles: the counter-rotating response to the steps of
// the held envelope adds up instead of averaging out. Its bound is xi0 w0 / (4 w) of the rate.
TEST(ControlLoops, SteerWithinTheSecondOrderBoundAtACommensurateFrequency) {
  LoopSetup setup;
  setup.makeIdeal();
  setup.control.virtual_rate = toRadians(12.0);
  Loop loop(setup);
  ASSERT_TRUE(loop.lockTime(1.0).has_value());
  while (loop.time() < 1.5) loop.step();
  const double begin = loop.step().elements.orbit.theta;
  for (int n = 0; n < 2000; ++n) loop.step();
  const double turned = loop.loops().process(loop.block()).elements.orbit.theta - begin;
  EXPECT_NEAR(turned / (-2.001 * setup.control.virtual_rate), 1.0,
              0.25 * setup.plant.resonator.dampingRatio());
}

TEST(ControlLoops, FollowATrueRotationTimesTheAngularGain) {
  LoopSetup setup;
  setup.makeIdeal();
  setup.plant.resonator.angular_gain = 0.37;
  setup.plant.rotation.rate = toRadians(360.0);
  Loop loop(setup);
  ASSERT_TRUE(loop.lockTime(1.0).has_value());
  while (loop.time() < 1.0) loop.step();
  const double begin = loop.step().elements.orbit.theta;
  for (int n = 0; n < 1000; ++n) loop.step();
  const double turned = loop.loops().process(loop.block()).elements.orbit.theta - begin;
  EXPECT_NEAR(turned, -0.37 * kTwoPi * 1.001, 2e-5 * kTwoPi);
}

// Both directions: the setpoint cannot be reached for a while, then it can.
TEST(ControlLoops, DoNotWindUpAtTheDriveLimit) {
  for (const double amplitude : {0.5, 1.0}) {
    LoopSetup setup;
    setup.control.drive_limit = 6.0;
    setup.control.amplitude = amplitude;
    Loop loop(setup);
    ASSERT_TRUE(loop.lockTime(2.0).has_value());
    double highest = 0.0;
    while (loop.time() < 3.0) highest = std::max(highest, loop.step().elements.orbit.a);
    EXPECT_LT(highest, 1.01 * amplitude);
  }
}

TEST(ControlLoops, CoastThroughSamplesThatAreNotFinite) {
  LoopSetup setup;
  setup.control.virtual_rate = toRadians(12.0);
  Loop loop(setup);
  ASSERT_TRUE(loop.lockTime(1.0).has_value());
  while (loop.time() < 0.5) loop.step();
  for (int n = 0; n < 5; ++n) {
    loop.block().x[17] =
        n % 2 ? std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
    const LoopOutput& output = loop.step();
    EXPECT_TRUE(output.elements.status.invalid_samples);
    EXPECT_FALSE(output.elements.status.usable());
    EXPECT_TRUE(output.command.envelope.allFinite());
    EXPECT_TRUE(std::isfinite(output.elements.orbit.a));
  }
  EXPECT_TRUE(loop.step().elements.status.invalid_samples) << "the filter still holds bad samples";
  int usable = 0;
  for (int n = 0; n < 100; ++n) usable += loop.step().elements.status.usable() ? 1 : 0;
  EXPECT_EQ(usable, 100) << "five bad blocks must not cost the lock";
}

TEST(ControlLoops, CoastThroughAReferenceThatIsNotFinite) {
  LoopSetup setup;
  setup.control.virtual_rate = toRadians(12.0);
  Loop loop(setup);
  ASSERT_TRUE(loop.lockTime(1.0).has_value());
  while (loop.time() < 0.5) loop.step();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int n = 0; n < 4; ++n) {
    const double frequency = loop.block().reference_frequency;
    (n % 2 ? loop.block().reference_phase : loop.block().reference_frequency) =
        n < 2 ? nan : std::numeric_limits<double>::infinity();
    const LoopOutput& output = loop.step();
    EXPECT_TRUE(output.elements.status.invalid_samples);
    EXPECT_TRUE(output.command.envelope.allFinite());
    EXPECT_NEAR(output.gains.reference_frequency, frequency, 1e-6 * frequency);
    EXPECT_TRUE(std::isfinite(output.gains.reference_phase + output.command.reference_phase +
                              output.command.reference_frequency));
  }
  loop.step();
  int usable = 0;
  for (int n = 0; n < 100; ++n) usable += loop.step().elements.status.usable() ? 1 : 0;
  EXPECT_EQ(usable, 100) << "four bad references must not cost the lock";
}

// As far as the plant has gone meanwhile: it runs on with the last command too.
TEST(ControlLoops, KnowTheReferenceAfterMissedBlocks) {
  LoopSetup setup;
  for (const int missed : {0, 1, 7}) {
    PlantSimulator plant(setup.plant, setup.converter, 1, 1, kStart);
    ControlLoops loops(setup.device, setup.control, {}, setup.converter);
    DisplacementBlock block = plant.start();
    for (int n = 0; n < 500; ++n) block = plant.step(loops.process(block).command);
    for (int n = 0; n < missed; ++n) block = plant.coast();
    const double phase = block.reference_phase;
    block.reference_phase = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NEAR(wrapToPi(loops.process(block).gains.reference_phase - phase), 0.0, 1e-9) << missed;
  }
}

// Nothing of the first session may be seen in the second: not in the filter, the integrators, what
// was learnt, the turns counted, the locks, nor what was decided.
TEST(ControlLoops, ANewSessionFindsThemAsNewlyMade) {
  LoopSetup setup;
  setup.plant.sense.noise_density = 5e-6;
  setup.control.virtual_rate = toRadians(12.0);
  setup.corrections.gamma1 = 0.01;
  for (const int first_blocks : {1, 100, 4000}) {
    for (const int missed : {0, 1, 37}) {  // blocks of the second session
      ControlLoops used(setup.device, setup.control, {}, setup.converter, setup.corrections);
      PlantSimulator first(setup.plant, setup.converter, 3, 1, kStart);
      DisplacementBlock block = first.start();
      for (int n = 0; n < first_blocks; ++n) {
        if (n == 2000) {
          LoopSettings settings;
          settings.virtual_rate = -1.0;
          settings.amplitude_modulation = 0.1;
          used.setSettings(settings);
          used.setCompensation({1e-7, 2e-7});
        }
        block = first.step(used.process(block).command);
      }
      ControlLoops fresh(setup.device, setup.control, {}, setup.converter, setup.corrections);
      PlantSimulator plant(setup.plant, setup.converter, 4, 2, kStart);
      block = plant.start();
      for (int n = 0; n < missed; ++n) block = plant.coast();
      for (int n = 0; n < 500; ++n) {
        const LoopOutput& one = used.process(block);
        const LoopOutput& other = fresh.process(block);
        ASSERT_EQ(one.elements.orbit.a, other.elements.orbit.a) << n;
        ASSERT_EQ(one.elements.orbit.theta, other.elements.orbit.theta) << n;
        ASSERT_EQ(one.elements.theta_rate, other.elements.theta_rate) << n;
        ASSERT_EQ(one.elements.status.invalid_samples, other.elements.status.invalid_samples) << n;
        ASSERT_EQ(one.elements.status.usable(), other.elements.status.usable()) << n;
        ASSERT_EQ(one.gains.drive.total(), other.gains.drive.total()) << n;
        ASSERT_EQ(one.command.envelope, other.command.envelope) << n;
        ASSERT_EQ(one.command.reference_frequency, other.command.reference_frequency) << n;
        if (n < 2) {
          EXPECT_LT(one.elements.orbit.a, 0.02) << "the second ring is at rest";
        }
        block = plant.step(one.command);
      }
    }
  }
}

// Whatever is corrected, within the ranges that the parameters allow.
TEST(ControlLoops, NeverSendMoreThanTheDriveLimit) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> between(-1.0, 1.0);
  for (int trial = 0; trial < 12; ++trial) {
    LoopSetup setup;
    setup.control.virtual_rate = between(engine) * 2.0;
    setup.control.drive_limit = 6.0 + 4.0 * between(engine);
    setup.control.hold_gain = 0.55 + 0.45 * between(engine);
    setup.control.hold_delay = 5e-6 * (1.0 + between(engine));
    DrivePath& path = setup.corrections.drive_path;
    path.mismatch = 0.3 * between(engine);
    path.skew = 0.3 * between(engine);
    path.rotation = 0.3 * between(engine);
    path.phase_mismatch = 0.3 * between(engine);
    setup.corrections.gamma1 = 0.1 * between(engine);
    Loop loop(setup);
    double largest = 0.0;
    DriveCommand sent;
    while (loop.time() < 0.6) {
      const LoopOutput& output = loop.step();
      if (output.elements.stamp.sequence > 0) {
        // What is told to have acted is what was sent, less the corrections.
        const Eigen::Vector2cd asked =
            setup.control.hold_gain *
            std::polar(1.0, -sent.reference_frequency * setup.control.hold_delay) *
            (setup.corrections.driveCorrection().inverse() * sent.envelope);
        EXPECT_LT((output.gains.drive.total() - asked).norm(), 1e-9);
      }
      sent = output.command;
      largest = std::max(largest, sent.envelope.cwiseAbs().maxCoeff());
    }
    EXPECT_LE(largest, setup.control.drive_limit * (1.0 + 1e-12));
    EXPECT_GT(largest, 0.3 * setup.control.drive_limit);
  }
}

TEST(ControlLoops, SayWhenTheDriveWasCutByItsConverter) {
  LoopSetup setup;
  setup.plant.drive.zero_order_hold = true;
  setup.plant.drive.dac_bits = 14;
  setup.plant.drive.dac_range = 2.0;  // the loops send up to 10 V
  Loop loop(setup);
  int clipped = 0;
  while (loop.time() < 0.2) {
    const std::uint32_t samples = loop.block().clipped_drive_samples;
    const bool limited = loop.block().driven;
    const LoopOutput& output = loop.step();
    EXPECT_LE(samples, 400u);
    if (samples > 0) {
      ++clipped;
      EXPECT_TRUE(limited);
      EXPECT_TRUE(output.elements.status.drive_saturated);
      EXPECT_TRUE(output.gains.status.drive_saturated);
      EXPECT_FALSE(output.elements.status.usable());
    }
  }
  EXPECT_GT(clipped, 50);
}

TEST(ControlLoops, SayWhenTheConverterSaturates) {
  LoopSetup setup;
  setup.plant.sense.adc_bits = 18;
  setup.plant.sense.adc_range = 0.9;  // below the setpoint
  Loop loop(setup);
  bool seen = false;
  while (loop.time() < 0.5) {
    const LoopStatus status = loop.step().elements.status;
    seen = seen || status.converter_saturated;
    EXPECT_FALSE(status.converter_saturated && status.usable());
  }
  EXPECT_TRUE(seen);
}

TEST(ControlLoops, LoseTheLockWithTheOrbitAndFindItAgain) {
  LoopSetup setup;
  Loop loop(setup);
  ASSERT_TRUE(loop.lockTime(1.0).has_value());
  bool lost = false;
  for (int n = 0; n < 20; ++n) {  // the pick-off is disconnected
    std::fill(loop.block().x.begin(), loop.block().x.end(), 0.0);
    std::fill(loop.block().y.begin(), loop.block().y.end(), 0.0);
    lost = !loop.step().elements.status.locked() || lost;
  }
  EXPECT_TRUE(lost);
  EXPECT_TRUE(loop.lockTime(loop.time() + 1.5).has_value());
}

TEST(ControlLoops, CorrectAHeldDriveByItsKnownDelayAndGain) {
  LoopSetup setup;
  setup.control.virtual_rate = toRadians(12.0);
  setup.plant.drive.zero_order_hold = true;
  setup.control.hold_delay = 2.5e-6;
  const double half = 0.5 * setup.plant.resonator.angularFrequency() / 200e3;
  setup.control.hold_gain = std::sin(half) / half;
  Loop loop(setup);
  ASSERT_TRUE(loop.lockTime(1.0).has_value());
  while (loop.time() < 1.0) loop.step();
  EXPECT_NEAR(toDegrees(loop.trueOrbit().phi), -90.0, 0.01);
}

TEST(ControlLoops, ContributionsSumToWhatActedAndGainsBelongToTheirBlock) {
  LoopSetup setup;
  setup.control.virtual_rate = toRadians(12.0);
  Loop loop(setup);
  ASSERT_TRUE(loop.lockTime(1.0).has_value());
  for (int n = 0; n < 10; ++n) loop.step();
  const DriveCommand sent = loop.step().command;
  const LoopOutput& next = loop.step();
  EXPECT_EQ(next.gains.stamp.sequence, sent.answers_sequence + 1);
  EXPECT_LT((next.gains.drive.total() - sent.envelope).norm(), 1e-12);
  EXPECT_EQ(next.gains.reference_frequency, sent.reference_frequency);
  EXPECT_EQ(next.gains.reference_phase, sent.reference_phase);
  EXPECT_GT(next.gains.drive.steering.norm(), 0.3);
}

}  // namespace
}  // namespace cvg
