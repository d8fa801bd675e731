#include "ring_gyro/simulation/mode_tuning.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "ring_gyro/common/angle.h"

namespace cvg {
namespace {

LoopConfiguration splitDevice() {
  LoopConfiguration configuration;
  ResonatorParameters& r = configuration.plant.resonator;
  r.natural_frequency = configuration.device.natural_frequency = 14195.0;
  r.quality_factor = configuration.device.quality_factor = 22000.0;
  r.drive_gain = configuration.device.drive_gain = 2.19e6;
  r.gamma1 = 0.035;
  r.gamma2 = -0.006;
  r.mu1 = 90e-6;
  r.mu2 = -56e-6;  // 1.5 Hz
  r.tuning_gain = 1e-6;
  configuration.plant.sense.noise_density = 5e-6;
  configuration.control.virtual_rate = toRadians(12.0);
  return configuration;
}

TEST(ModeTuning, FromAHertzAndAHalfToBelowATenthOfAMillihertz) {
  TuningOptions options;
  options.assumed_tuning_gain = 1.2e-6;  // 20 % wrong
  const auto passes = tuneModes(splitDevice(), options, [](const TuningPass& pass) {
    std::printf("[figure] tuning pass: split %.3e Hz, identified %.3e Hz\n", pass.true_split,
                pass.split);
  });
  EXPECT_NEAR(passes.front().true_split, 1.5, 0.01);
  EXPECT_LT(passes.back().true_split, 1e-4);  // must 10 mHz, aim 0.1 mHz
  EXPECT_NEAR(passes.back().split, passes.back().true_split, 2e-5);
}

TEST(ModeTuning, NeedsASensitivity) {
  EXPECT_THROW(tuneModes(splitDevice(), {}, {}), std::invalid_argument);
}

TEST(TuningSquares, GoToOneElectrodeOfEachPair) {
  ResonatorParameters ring;
  TuningSquares{9.0, -16.0}.applyTo(ring);
  EXPECT_EQ(ring.tuning_voltage_0, 3.0);
  EXPECT_EQ(ring.tuning_voltage_90, 0.0);
  EXPECT_EQ(ring.tuning_voltage_45, 0.0);
  EXPECT_EQ(ring.tuning_voltage_135, 4.0);
  EXPECT_EQ(TuningSquares::of(ring).across, -16.0);
}

}  // namespace
}  // namespace cvg
