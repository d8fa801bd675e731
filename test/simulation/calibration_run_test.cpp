#include "ring_gyro/simulation/calibration_run.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "ring_gyro/calibration/calibration_report.h"
#include "ring_gyro/calibration/rate_parity.h"
#include "ring_gyro/common/angle.h"
#include "ring_gyro/simulation/calibration_judgement.h"

namespace cvg {
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
  return c;
}

CalibrationResult calibrated(const LoopConfiguration& configuration, std::string& failure,
                             std::vector<CalibrationResult>* found = nullptr) {
  CalibrationRun run(configuration);
  while (run.time() < 1000.0) {
    const auto step = run.step();
    if (!step.command) continue;
    failure = step.command->failure;
    if (found && step.command->found) found->push_back(run.result());
    if (step.command->finished || !failure.empty()) return run.result();
  }
  failure = "no end";
  return {};
}

LoopConfiguration withResult(LoopConfiguration c, const CalibrationResult& result) {
  c.corrections = result.corrections;
  c.device = result.device;
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
  EXPECT_NEAR(result.device.quality_factor / 5000.0, 1.0, 1e-3);
  EXPECT_NEAR(result.corrections.pickoff_cubic, 0.02, 2e-4);
  EXPECT_NEAR(result.device.angular_gain, 1.0, 1e-4);
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

/// `told`: k of the loops, `true_gain`: of the ring. Slow verification, which few turns fit into.
LoopConfiguration deviceWithGain(double told, double true_gain) {
  LoopConfiguration c = device();
  c.device.angular_gain = told;
  c.plant.resonator.angular_gain = true_gain;
  c.calibration_run.table_time = 10.0;
  c.calibration_run.verification_rates = {0.4};
  c.calibration_run.verification_time = 10.0;
  return c;
}

class CalibrationOfGain : public ::testing::TestWithParam<std::pair<double, double>> {};

TEST_P(CalibrationOfGain, LegsAreSizedByTurnsOfThePattern) {
  const auto [told, gain] = GetParam();
  std::string failure;
  const CalibrationResult result = calibrated(deviceWithGain(told, gain), failure);
  ASSERT_EQ(failure, "");
  EXPECT_NEAR(result.device.angular_gain / gain, 1.0, 1e-4);
  ASSERT_EQ(result.verifications.size(), 1u);
  const Verification& verification = result.verifications.front();
  EXPECT_EQ(verification.rate, 0.4);
  EXPECT_NEAR(verification.forward_scale, 0.0, 5e-4);
  EXPECT_NEAR(verification.backward_scale, 0.0, 5e-4);
  // All of them are rates of the case.
  AngleHarmonics drift = verification.drift;
  EXPECT_NEAR(verification.drift_peak_to_peak, peakToPeak(drift), 1e-15);
  ASSERT_TRUE(result.threshold.has_value());
  const ThresholdTest& test = *result.threshold;
  EXPECT_NEAR(test.threshold, std::abs(largestMagnitude(drift).value), 1e-15);
  EXPECT_EQ(std::abs(test.rate), 2.0 * test.threshold);
  const double time = test.expected / (-result.device.angular_gain * test.rate);
  EXPECT_NEAR(time, 20.0, 1.0);
  EXPECT_LT(result.duration, 600.0);
}

INSTANTIATE_TEST_SUITE_P(AngularGains, CalibrationOfGain,
                         ::testing::Values(std::pair(0.37, 0.37), std::pair(1.0, 0.37),
                                           std::pair(0.9, 0.9), std::pair(0.37, 1.0)));

/// The drift of a pattern is that of the ring whatever k: as a rate of the case it is 1/k of it.
TEST(CalibrationRun, JudgesRatesOfTheCase) {
  LoopConfiguration one = withoutNoise(deviceWithGain(1.0, 1.0));
  LoopConfiguration slow = withoutNoise(deviceWithGain(0.37, 0.37));
  one.plant.resonator.gamma1 = slow.plant.resonator.gamma1 = 1e-3;
  one.plant.resonator.gamma2 = slow.plant.resonator.gamma2 = 0.0;
  one.plant.sense = slow.plant.sense = SenseParameters();
  one.plant.drive = slow.plant.drive = DriveParameters();
  // 3 s are under a turn and a quarter: it takes as long as the pattern needs.
  const CalibrationJudgement of_one = judgeCalibration(one, 0.8, 3.0);
  const CalibrationJudgement of_slow = judgeCalibration(slow, 0.8 / 0.37, 3.0);
  EXPECT_NEAR(0.37 * of_slow.threshold / of_one.threshold, 1.0, 0.01);
  EXPECT_NEAR(0.37 * of_slow.drift_peak_to_peak / of_one.drift_peak_to_peak, 1.0, 0.01);
  EXPECT_NEAR(0.37 * of_slow.forward_peak / of_one.forward_peak, 1.0, 0.01);
  slow.plant.resonator.angular_gain = 0.0;
  EXPECT_THROW(judgeCalibration(slow, 0.8, 3.0), std::invalid_argument);
}

TEST(CalibrationRun, HandsOutEachStageWhenItIsFound) {
  LoopConfiguration configuration = deviceWithGain(1.0, 1.0);
  std::string failure;
  std::vector<CalibrationResult> found;
  const CalibrationResult result = calibrated(configuration, failure, &found);
  ASSERT_EQ(failure, "");
  const std::vector<std::string> stages = {"identification 1", "identification 2", "drift 1",
                                           "drift 2",          "angle map",        "verification",
                                           "rate threshold"};
  ASSERT_EQ(found.size(), stages.size());
  for (std::size_t k = 0; k < stages.size(); ++k) {
    const auto first = stages.begin() + static_cast<std::ptrdiff_t>(k) + 1;
    EXPECT_EQ(found[k].missing, std::vector<std::string>(first, stages.end())) << stages[k];
    EXPECT_NEAR(found[k].corrections.gamma1, 0.03, 0.01);
  }
  EXPECT_EQ(found[0].drift_rounds.size(), 0u);
  EXPECT_EQ(found[3].corrections.drift.cosine, result.corrections.drift.cosine);
  EXPECT_FALSE(found[3].angle_map_measured);
  // Verification comes last and changes nothing of what is written.
  EXPECT_EQ(found[4].corrections.angle_map.sine, result.corrections.angle_map.sine);
  EXPECT_EQ(found[4].device.angular_gain, result.device.angular_gain);
}

TEST(CalibrationRun, ATableThatDoesNotTurnIsNamedAndTheRestIsKept) {
  LoopConfiguration configuration = deviceWithGain(1.0, 0.0);
  std::string failure;
  std::vector<CalibrationResult> found;
  calibrated(configuration, failure, &found);
  EXPECT_NE(failure.find("angle map"), std::string::npos) << failure;
  EXPECT_NE(failure.find("does the table turn?"), std::string::npos) << failure;
  ASSERT_EQ(found.size(), 4u);
  EXPECT_EQ(found.back().missing.front(), "angle map");
}

TEST(CalibrationRun, AppliesNoAngleMapThatWasNotMeasured) {
  LoopConfiguration configuration = device();
  configuration.calibration_run.rate_table = false;
  configuration.calibration_run.verification_rates.clear();
  std::string failure;
  const CalibrationResult result = calibrated(configuration, failure);
  ASSERT_EQ(failure, "");
  EXPECT_FALSE(result.angle_map_measured);
  EXPECT_EQ(result.corrections.angle_map.orders(), 0u);
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
}  // namespace cvg
