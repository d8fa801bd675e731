#include "ring_gyro/identification/model/frequency_response.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/simulation/swept_sine.h"

namespace cvg {
namespace {

PlantParameters splitRing() {
  PlantParameters plant;
  ResonatorParameters& r = plant.resonator;
  r.natural_frequency = 14195.0;
  r.quality_factor = 22000.0;
  r.gamma1 = 0.035;
  r.gamma2 = -0.006;
  r.mu1 = 90e-6;
  r.mu2 = -56e-6;  // 1.5 Hz split
  r.drive_gain = 2.19e6;
  plant.sense.noise_density = 5e-6;
  return plant;
}

SweepParameters sweepAbout(double centre) {
  SweepParameters sweep;
  sweep.centre = centre;
  sweep.span = 6.0;
  sweep.points = 31;
  sweep.drive = 0.02;
  return sweep;
}

TEST(FrequencyResponse, FindsTheDeviceThroughItsElectronics) {
  PlantParameters plant = splitRing();
  plant.sense.axes.phase_delay = 0.02;
  const ResonatorParameters& r = plant.resonator;
  const FrequencyResponseFit fit =
      fitFrequencyResponse(sweepSine(plant, {}, {}, sweepAbout(14195.2), 1, {}));
  std::printf(
      "[figure] swept sine: f0 error %.1e Hz, Q error %.1e, ks error %.1e relative, "
      "split %.4f Hz\n",
      fit.natural_frequency - r.natural_frequency, fit.quality_factor / 22000.0 - 1.0,
      fit.device.drive_gain / r.drive_gain - 1.0, fit.split);
  EXPECT_NEAR(fit.natural_frequency, r.natural_frequency, 1e-3);
  EXPECT_NEAR(fit.quality_factor / r.quality_factor, 1.0, 2e-3);
  EXPECT_NEAR(fit.device.drive_gain / r.drive_gain, 1.0, 2e-3);
  EXPECT_NEAR(fit.device.gamma1, r.gamma1, 2e-3);
  EXPECT_NEAR(fit.device.gamma2, r.gamma2, 2e-3);
  EXPECT_NEAR(fit.device.mu1, r.mu1, 1e-7);
  EXPECT_NEAR(fit.device.mu2, r.mu2, 1e-7);
  EXPECT_NEAR(fit.phase_delay, 0.02, 2e-3);
  EXPECT_NEAR(fit.split, std::hypot(r.mu1, r.mu2) * r.natural_frequency, 5e-3);
}

TEST(FrequencyResponse, RingDownFindsBothModes) {
  const PlantParameters plant = splitRing();
  const ResonatorParameters& r = plant.resonator;
  const auto modes = fitRingDown(recordRingDown(plant, {}, {}, sweepAbout(14195.2), 1));
  const double split = std::hypot(r.mu1, r.mu2) * r.natural_frequency;
  EXPECT_NEAR(modes[1].frequency - modes[0].frequency, split, 2e-3);
  EXPECT_NEAR(0.5 * (modes[0].frequency + modes[1].frequency), r.natural_frequency, 1e-3);
  // The damping of a mode has the mismatch along its axis.
  const double angle = 0.5 * std::atan2(r.mu2, r.mu1);
  const double along = r.gamma1 * std::cos(2.0 * angle) + r.gamma2 * std::sin(2.0 * angle);
  EXPECT_NEAR(modes[1].quality_factor * (1.0 + along) / r.quality_factor, 1.0, 2e-3);
  EXPECT_NEAR(modes[0].quality_factor * (1.0 - along) / r.quality_factor, 1.0, 2e-3);
}

TEST(FrequencyResponse, PeakGainGivesKsOnATunedRing) {
  PlantParameters plant = splitRing();
  plant.resonator.mu1 = plant.resonator.mu2 = 0.0;
  plant.resonator.gamma1 = plant.resonator.gamma2 = 0.0;
  const FrequencyResponseFit fit =
      fitFrequencyResponse(sweepSine(plant, {}, {}, sweepAbout(14195.0), 1, {}));
  EXPECT_NEAR(fit.drive_gain_peak / plant.resonator.drive_gain, 1.0, 2e-3);
}

TEST(FrequencyResponse, RefusesWhatCannotBeFitted) {
  EXPECT_THROW(fitFrequencyResponse({}), std::invalid_argument);
  RingDown one_mode;
  one_mode.frequency = 14e3;
  one_mode.period = 1e-3;
  one_mode.runs.emplace_back();
  for (int k = 0; k < 100; ++k) {
    one_mode.runs.back().push_back({std::complex<double>(std::exp(-0.002 * k), 0.0), 0.0});
  }
  EXPECT_THROW(fitRingDown(one_mode), std::invalid_argument);
}

}  // namespace
}  // namespace cvg
