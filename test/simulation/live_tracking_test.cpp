// A gyroscope that works while its temperature drifts: the identifier follows, the compensation
// too.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include "ring_gyro/analysis/rate_harmonics.h"
#include "ring_gyro/common/angle.h"
#include "ring_gyro/configuration/configuration_reader.h"
#include "ring_gyro/signals/calibration_command.h"
#include "ring_gyro/simulation/closed_loop.h"

namespace cvg {
namespace {

LoopConfiguration drifting(const std::vector<std::string>& more = {}) {
  std::vector<std::string> overrides = {"sense/cubic=0",
                                        // 1e-3 a minute of f0, Q and gamma.
                                        "resonator/temperature_rate=0.0166666666667",
                                        "resonator/frequency_temperature_coefficient=1e-3",
                                        "resonator/quality_temperature_coefficient=1e-3",
                                        "resonator/gamma_temperature_coefficient=1e-3",
                                        "identification/memory_time=10",
                                        "control/compensation=true", "compensation/start_after=30"};
  overrides.insert(overrides.end(), more.begin(), more.end());
  return readConfigurationFile(RING_GYRO_CONFIG_DIR "/paper_experiment.yaml", overrides);
}

struct Outcome {
  PlantTruth truth;
  ParameterEstimate estimate;
  double drift_peak_to_peak = 0.0;  // over the last turns [rad/s]
  double largest_jump = 0.0;        // of the angle from block to block, less the mean rate [rad]
};

Outcome run(const LoopConfiguration& configuration, double duration) {
  ClosedLoop loop(configuration);
  Outcome outcome;
  std::vector<AngleSample> angles;
  std::optional<double> angle_before;
  while (loop.time() < duration) {
    const LoopRecord now = loop.step();
    if (now.estimate) outcome.estimate = *now.estimate;
    outcome.truth = now.truth();
    const OrbitalElements& elements = now.loops.elements;
    if (loop.time() < 20.0) continue;
    EXPECT_TRUE(elements.status.usable()) << loop.time();
    if (angle_before) {
      const double step = elements.angle - *angle_before - 1e-3 * elements.theta_rate;
      outcome.largest_jump = std::max(outcome.largest_jump, std::abs(step));
    }
    angle_before = elements.angle;
    if (loop.time() > duration - 62.0) angles.push_back({loop.time(), elements.orbit.theta});
  }
  outcome.drift_peak_to_peak = fitRateHarmonics(angles).peak_to_peak;
  return outcome;
}

TEST(LiveTracking, FollowsADriftingDeviceWithoutAJumpOfTheAngle) {
  const Outcome tracked = run(drifting(), 600.0);
  const double gamma1_error = tracked.estimate.value[kGamma1] - tracked.truth.gamma1;
  const double gamma2_error = tracked.estimate.value[kGamma2] - tracked.truth.gamma2;
  // With an endless memory the filter takes the device for a constant and follows ever more slowly.
  const Outcome constant = run(drifting({"identification/memory_time=0"}), 600.0);
  std::printf(
      "[figure] after 10 min of 1e-3 a minute: gamma changed by %.1e, error %.1e; drift %.5f deg/s "
      "p-p, %.5f without tracking; largest step of the angle %.1e rad (noise of a block 1.6e-4)\n",
      tracked.truth.gamma1 - 0.035, std::hypot(gamma1_error, gamma2_error),
      toDegrees(tracked.drift_peak_to_peak), toDegrees(constant.drift_peak_to_peak),
      tracked.largest_jump);
  EXPECT_NEAR(tracked.truth.gamma1 / 0.035, 1.01, 1e-6);
  EXPECT_LT(std::hypot(gamma1_error, gamma2_error), 5e-5);
  EXPECT_LT(toDegrees(tracked.drift_peak_to_peak), 0.01);
  EXPECT_GT(toDegrees(constant.drift_peak_to_peak), 0.02);
  EXPECT_LT(tracked.largest_jump, 7.0 * 1.6e-4 * std::sqrt(2.0));
}

TEST(LiveTracking, FreezesWhatAPatternAtRestDoesNotShow) {
  LoopConfiguration configuration = drifting();
  ClosedLoop loop(configuration);
  ParameterEstimate at_rest;
  ParameterEstimate last;
  bool resting = false;
  while (loop.time() < 660.0) {
    const LoopRecord now = loop.step();
    if (now.estimate) last = *now.estimate;
    if (!resting && loop.time() > 60.0) {
      resting = true;
      LoopSettings still;  // compensation comes again with the next decision
      loop.loops().setSettings(still);
      at_rest = last;
    }
  }
  for (int k = kGamma1; k <= kDriveGain; ++k) {
    const auto index = static_cast<StateIndex>(k);
    std::printf("[figure] ten minutes at rest: sigma of state %d from %.2e to %.2e\n", k,
                at_rest.sigma(index), last.sigma(index));
    EXPECT_LT(last.sigma(index), 3.0 * at_rest.sigma(index)) << k;
  }
  EXPECT_LT(std::hypot(last.value[kGamma1] - last.residual_gamma1, last.value[kGamma2]), 0.05);
  EXPECT_TRUE(last.parameter_variance.allFinite());
}

}  // namespace
}  // namespace cvg
