#include "ring_gyro/simulation/calibration_run.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "ring_gyro/calibration/calibration_report.h"
#include "ring_gyro/calibration/rate_parity.h"
#include "ring_gyro/common/angle.h"
#include "ring_gyro/simulation/calibration_judgement.h"

namespace ring_gyro {
namespace {

/// A device that decays fast, so that a whole run is short; with all linear errors and the cubic.
LoopConfiguration device() {
  LoopConfiguration c;
  c.device = {14000.0, 5000.0, 2e6, 1.0};
  ResonatorParameters& ring = c.plant.resonator;
  ring.natural_frequency = 14000.0;
  ring.quality_factor = 5000.0;
  ring.drive_gain = 2e6;
  ring.gamma1 = 0.03;
  ring.gamma2 = -0.02;
  ring.mu1 = 4e-6;
  ring.mu2 = -3e-6;
  SenseParameters& sense = c.plant.sense;
  sense.noise_density = 5e-6;
  sense.cubic = 0.02;
  sense.axes = {1.005, 0.995, 0.005, 0.009, 0.0017};
  c.plant.drive.axes = {1.004, 0.996, 0.005, 0.009, 0.0017};
  c.control.virtual_rate = 0.2;
  CalibrationRunParameters& run = c.calibration_run;
  run.identification_time = 20.0;
  run.drift_rate = 0.6;
  run.drift_time = 10.0;
  run.last_drift_time = 30.0;
  run.drift_rounds = 2;
  run.table_rate = 2.0;
  run.table_time = 30.0;
  run.verification_rates = {1.0};
  run.verification_time = 20.0;
  run.threshold_time = 20.0;
  c.shareDevice();
  return c;
}

CalibrationResult calibrated(const LoopConfiguration& configuration, std::string& failure) {
  CalibrationRun run(configuration);
  while (run.time() < 1000.0) {
    const auto step = run.step();
    if (!step.command) continue;
    failure = step.command->failure;
    if (step.command->finished || !failure.empty()) return run.result();
  }
  failure = "no end";
  return {};
}

LoopConfiguration withResult(LoopConfiguration c, const CalibrationResult& result) {
  c.calibration = result.calibration;
  c.device = {result.natural_frequency, result.quality_factor, result.drive_gain,
              result.angular_gain};
  c.shareDevice();
  return c;
}

LoopConfiguration withoutNoise(LoopConfiguration c) {
  c.plant.sense.noise_density = 0.0;
  return c;
}

TEST(CalibrationRun, FindsAndCancelsWhatDependsOnTheAngle) {
  const LoopConfiguration before = device();
  std::string failure;
  const CalibrationResult result = calibrated(before, failure);
  ASSERT_EQ(failure, "");
  std::printf("%s", calibrationText(result).c_str());
  ASSERT_TRUE(result.angle_map_measured);
  EXPECT_NEAR(result.quality_factor / 5000.0, 1.0, 1e-3);
  EXPECT_NEAR(result.calibration.pickoff_cubic, 0.02, 2e-4);
  EXPECT_NEAR(result.angular_gain, 1.0, 1e-4);
  ASSERT_TRUE(result.threshold.has_value());
  EXPECT_TRUE(result.threshold->followed());

  const double rate = 1.5;  // not tuned at
  const CalibrationJudgement was = judgeCalibration(withoutNoise(before), rate, 20.0);
  const CalibrationJudgement is =
      judgeCalibration(withoutNoise(withResult(before, result)), rate, 20.0);
  std::printf(
      "[figure] calibration of a device of Q 5000: drift p-p %.4f -> %.5f deg/s, slope error %.0f "
      "-> %.1f ppm\n",
      toDegrees(was.drift_peak_to_peak), toDegrees(is.drift_peak_to_peak), 1e6 * was.slope_error,
      1e6 * is.slope_error);
  EXPECT_GT(toDegrees(was.drift_peak_to_peak), 30.0);
  EXPECT_LT(toDegrees(is.drift_peak_to_peak), 0.02);
  EXPECT_GT(was.slope_error, 5e-3);
  EXPECT_LT(is.slope_error, 1e-4);
  EXPECT_LT(toDegrees(is.forward_peak), 0.03);
}

TEST(CalibrationRun, AppliesNoAngleMapThatWasNotMeasured) {
  LoopConfiguration configuration = device();
  configuration.calibration_run.rate_table = false;
  configuration.calibration_run.verification_rates.clear();
  std::string failure;
  const CalibrationResult result = calibrated(configuration, failure);
  ASSERT_EQ(failure, "");
  EXPECT_FALSE(result.angle_map_measured);
  EXPECT_EQ(result.calibration.angle_map.orders(), 0u);
  EXPECT_NE(calibrationText(result).find("not measured, none applied"), std::string::npos);
  const CalibrationJudgement judged =
      judgeCalibration(withoutNoise(withResult(configuration, result)), 1.5, 20.0);
  EXPECT_LT(toDegrees(judged.drift_peak_to_peak), 0.02);
  EXPECT_GT(judged.slope_error, 5e-3);  // the gain mismatch of the pick-off stays
}

TEST(CalibrationRun, SaysWhyItCannotGoOn) {
  LoopConfiguration configuration = device();
  configuration.calibration_run.survey_rate = 0.05;  // far below the drift
  std::string failure;
  calibrated(configuration, failure);
  EXPECT_NE(failure.find("survey"), std::string::npos) << failure;
  EXPECT_NE(failure.find("survey_rate"), std::string::npos) << failure;

  configuration = device();
  configuration.control.drive_limit = 1e-3;  // never locks
  failure.clear();
  calibrated(configuration, failure);
  EXPECT_NE(failure.find("locked"), std::string::npos) << failure;
}

}  // namespace
}  // namespace ring_gyro
