#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <string>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/configuration/configuration_reader.h"
#include "ring_gyro/control/control_loops.h"
#include "ring_gyro/resonator/plant_simulator.h"

namespace cvg {
namespace {

constexpr double kLockLimit = 1.0;  // [s]

/// A preset whose ring changes its resonance by 1 Hz/K.
LoopConfiguration presetWithTemperature(const std::string& preset, double drift) {
  LoopConfiguration configuration =
      readConfigurationFile(std::string(RING_GYRO_CONFIG_DIR) + "/" + preset + ".yaml");
  ResonatorParameters& ring = configuration.plant.resonator;
  ring.frequency_temperature_coefficient = 1.0 / ring.natural_frequency;
  ring.temperature_rate = drift;
  return configuration;
}

/// Plant and loops in lockstep, until messages between them are lost.
class Loop {
 public:
  explicit Loop(const LoopConfiguration& c)
      : plant_(c.plant, c.converter, 1, 1, c.run.startNanoseconds()),
        loops_(c.device, c.control, c.demodulation, c.converter, c.corrections),
        block_seconds_(c.converter.blockDuration()),
        block_(plant_.start()) {}

  const LoopOutput& step() {
    const LoopOutput& output = loops_.process(block_);
    block_ = plant_.step(output.command);
    return output;
  }
  void run(double seconds) {
    for (double t = 0.0; t < seconds; t += block_seconds_) step();
  }
  /// The plant goes on with the last drive, the loops see nothing of it.
  void loseBlocks(double seconds) {
    for (double t = 0.0; t < seconds; t += block_seconds_) block_ = plant_.coast();
  }
  /// Samples that are not finite, of which the loops see as little.
  void spoilBlocks(double seconds) {
    for (double t = 0.0; t < seconds; t += block_seconds_) {
      block_.x[3] = std::numeric_limits<double>::quiet_NaN();
      step();
    }
  }
  /// Time after which the loops are locked and stay so for a second; empty: later than `limit` [s].
  std::optional<double> lockTime(double limit) {
    double locked_since = -1.0;
    for (double t = 0.0; t < limit + 1.0; t += block_seconds_) {
      const bool locked = step().elements.status.usable();
      if (!locked)
        locked_since = -1.0;
      else if (locked_since < 0.0)
        locked_since = t;
    }
    if (locked_since < 0.0 || locked_since > limit) return {};
    return locked_since;
  }
  PlantSimulator& plant() { return plant_; }

 private:
  PlantSimulator plant_;
  ControlLoops loops_;
  double block_seconds_;
  DisplacementBlock block_;
};

/// The loops hold some NCO offset by then, and the swings with the angle.
constexpr double kLearningTime = 6.0;  // [s]

class Relock : public testing::TestWithParam<const char*> {};

TEST_P(Relock, AfterAStepOfTheResonance) {
  double longest = 0.0;
  for (const double step : {0.7, 3.0, 10.0, 20.0, 40.0}) {
    for (const double sign : {1.0, -1.0}) {
      Loop loop(presetWithTemperature(GetParam(), 0.0));
      loop.run(kLearningTime);
      loop.plant().setTemperature(sign * step);
      const auto time = loop.lockTime(kLockLimit);
      EXPECT_TRUE(time.has_value()) << sign * step << " Hz";
      longest = std::max(longest, time.value_or(kLockLimit));
    }
  }
  std::printf("[figure] %s: locked again at most %.3f s after a step of 40 Hz or less (must 1 s)\n",
              GetParam(), longest);
}

TEST_P(Relock, AfterOneStepUponAnother) {
  Loop loop(presetWithTemperature(GetParam(), 0.0));
  loop.run(1.0);
  double temperature = 0.0;
  for (const double step : {20.0, 20.0, -20.0, 20.0, -20.0, -20.0, -20.0, 15.0}) {
    temperature += step;
    loop.plant().setTemperature(temperature);
    EXPECT_TRUE(loop.lockTime(kLockLimit).has_value()) << "at " << temperature << " Hz";
  }
}

TEST_P(Relock, AfterAGapWhileTheResonanceDrifts) {
  double longest = 0.0;
  for (const double drift : {0.0, 0.42, -0.42}) {
    for (const double gap : {0.002, 0.1, 0.5, 1.0, 3.0, 10.0, 30.0, 60.0}) {
      for (const bool spoilt : {false, true}) {
        if (spoilt && gap > 10.0) continue;
        Loop loop(presetWithTemperature(GetParam(), drift));
        loop.run(kLearningTime);
        spoilt ? loop.spoilBlocks(gap) : loop.loseBlocks(gap);
        const auto time = loop.lockTime(kLockLimit);
        EXPECT_TRUE(time.has_value()) << gap << " s at " << drift << " Hz/s, spoilt " << spoilt;
        longest = std::max(longest, time.value_or(kLockLimit));
      }
    }
  }
  std::printf("[figure] %s: locked again at most %.3f s after a gap of 60 s or less (must 1 s)\n",
              GetParam(), longest);
}

// Learnt or corrected, the NCO stays within its range.
TEST(Relock, KeepsTheOscillatorInItsRange) {
  LoopConfiguration configuration = presetWithTemperature("paper_simulation", 1.0);
  configuration.control.frequency_offset = 0.0;
  configuration.control.frequency_range = 4.0;
  Loop loop(configuration);
  double farthest = 0.0;
  for (int n = 0; n < 20000; ++n) {
    const double frequency = loop.step().command.reference_frequency / kTwoPi;
    farthest = std::max(farthest, frequency - configuration.device.natural_frequency);
  }
  EXPECT_NEAR(farthest, 4.0, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Presets, Relock,
                         testing::Values("paper_simulation", "paper_experiment", "realistic",
                                         "untuned"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace cvg
