#include "ring_gyro/analysis/run_summary.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/demodulation/orbit.h"

namespace cvg {
namespace {

constexpr std::int64_t kBlock = 1'000'000;  // ns
constexpr std::uint64_t kLocked = 600;      // block
constexpr std::uint64_t kCompensated = 70'000;
constexpr double kDriftBefore = 0.07;  // rad/s
constexpr double kDriftAfter = 0.001;
const double kRate = toRadians(12.0);

BlockStamp stampOf(std::uint64_t sequence) {
  return {7, sequence, 1'000'000'000 + static_cast<std::int64_t>(sequence + 1) * kBlock, kBlock};
}

/// A run that locks, drifts, is compensated and drifts less, without noise.
class SyntheticRun {
 public:
  OrbitalElements elements() {
    OrbitalElements elements;
    elements.stamp = stampOf(sequence_);
    elements.orbit = {1.0, 0.0, theta_, -0.5 * kPi};
    const bool locked = sequence_ >= kLocked;
    elements.status.amplitude_locked = locked;
    elements.status.quadrature_locked = locked;
    elements.status.phase_locked = locked;
    return elements;
  }
  ControlGains gains() const {
    ControlGains gains;
    gains.stamp = stampOf(sequence_);
    gains.virtual_rate = kRate;
    gains.compensation.gain1 = compensation();
    return gains;
  }
  PlantTruth truth() const {
    PlantTruth truth;
    truth.stamp = stampOf(sequence_);
    const double phase_error = sequence_ == 40'000 ? 2e-3 : sequence_ < 1000 ? 0.5 : 1e-3;
    truth.envelope = envelopeFromOrbit({1.0, -2e-4, theta_, phase_error - 0.5 * kPi});
    truth.gamma1 = 0.02;
    truth.drive_gain = 1.1e5;
    return truth;
  }
  void next() {
    const double drift = compensation() > 0.0 ? kDriftAfter : kDriftBefore;
    constexpr int kSteps = 10;
    for (int i = 0; i < kSteps; ++i) {
      const double h = 1e-3 / kSteps;
      const auto rate = [&](double theta) { return -kRate + drift * std::sin(2.0 * theta); };
      theta_ += h * rate(theta_ + 0.5 * h * rate(theta_));
    }
    ++sequence_;
  }
  std::uint64_t sequence() const { return sequence_; }

 private:
  double compensation() const {
    if (sequence_ < kCompensated) return 0.0;
    const double ramp = 1e-3 * static_cast<double>(sequence_ - kCompensated);
    return 1e-6 * std::min(1.0, ramp);
  }

  std::uint64_t sequence_ = 0;
  double theta_ = 0.1;
};

ParameterEstimate estimateAt(std::uint64_t sequence, double gamma) {
  ParameterEstimate estimate;
  estimate.stamp = stampOf(sequence);
  estimate.used_blocks = sequence - kLocked;
  estimate.updated = true;
  estimate.value[kGamma1] = gamma;
  estimate.value[kDriveGain] = 1.1e5;
  estimate.parameter_variance[0] = 1e-12;
  return estimate;
}

RunRecord syntheticRecord(std::uint64_t blocks) {
  RunRecord record;
  SyntheticRun run;
  while (run.sequence() < blocks) {
    record.add(run.elements());
    record.add(run.gains());
    record.add(run.truth());
    run.next();
  }
  return record;
}

TEST(RunSummary, findsTheDriftBeforeAndAfterCompensation) {
  const RunSummary summary = summarise(syntheticRecord(140'000));
  ASSERT_TRUE(summary.before.harmonics) << summary.before.missing;
  ASSERT_TRUE(summary.after.harmonics) << summary.after.missing;
  EXPECT_NEAR(summary.before.harmonics->peak_to_peak, 2.0 * kDriftBefore, 1e-6);
  EXPECT_NEAR(summary.after.harmonics->peak_to_peak, 2.0 * kDriftAfter, 1e-6);
  EXPECT_NEAR(summary.after.harmonics->mean_rate, -kRate, 1e-7);
  EXPECT_NEAR(summary.before.begin_time, 1.6, 1e-9);
  EXPECT_NEAR(summary.before.end_time, 70.001, 1e-9);  // the first ramped gain is still zero
  EXPECT_NEAR(summary.after.begin_time, 70.99, 2e-3);
  EXPECT_EQ(summary.before.virtual_rate, kRate);
}

TEST(RunSummary, judgesTheLoopsByTheTruthAfterTheySettled) {
  const RunSummary summary = summarise(syntheticRecord(60'000));
  ASSERT_TRUE(summary.ring_up_time);
  EXPECT_NEAR(*summary.ring_up_time, 0.601, 1e-9);
  ASSERT_TRUE(summary.loop_errors);
  EXPECT_NEAR(summary.loop_errors->phase, 2e-3, 1e-12);
  EXPECT_NEAR(summary.loop_errors->quadrature, 2e-4, 1e-12);
  EXPECT_NEAR(summary.loop_errors->from_time, 1.6, 1e-9);
  EXPECT_EQ(summary.unlocked_blocks, 0u);
  EXPECT_EQ(summary.missing_blocks, 0u);
  EXPECT_EQ(summary.after.missing, "no such blocks");
}

TEST(RunSummary, estimatesBeforeCompensationAndAtTheEnd) {
  RunRecord record = syntheticRecord(75'000);
  record.add(estimateAt(30'000, 0.0201));
  record.add(estimateAt(69'999, 0.02002));
  record.add(estimateAt(74'999, 0.020001));
  const RunSummary summary = summarise(record);
  ASSERT_TRUE(summary.before_compensation);
  ASSERT_TRUE(summary.final_estimate);
  EXPECT_NEAR(summary.before_compensation->parameters[0].error(), 2e-5, 1e-12);
  EXPECT_NEAR(summary.before_compensation->time, 70.0, 1e-9);
  EXPECT_NEAR(summary.before_compensation->used_time, 69.399, 1e-9);
  EXPECT_NEAR(summary.final_estimate->parameters[0].error(), 1e-6, 1e-12);
  EXPECT_NEAR(summary.final_estimate->parameters[0].sigma, 1e-6, 1e-15);
  EXPECT_TRUE(summary.final_estimate->parameters[4].relative);
}

TEST(RunSummary, judgesTheFilter) {
  RunRecord record = syntheticRecord(40'000);
  const struct {
    std::uint64_t sequence;
    bool updated;
    bool converged;
    double squared;
  } updates[] = {{9'999, true, true, 1.0},
                 {14'999, true, false, 7.0},
                 {19'999, true, true, 3.0},
                 {24'999, false, true, 100.0},
                 {29'999, true, true, 1.0}};
  for (const auto& update : updates) {
    ParameterEstimate estimate = estimateAt(update.sequence, 0.02);
    estimate.updated = update.updated;
    estimate.converged = update.converged;
    estimate.normalised_innovation_squared = update.squared;
    record.add(estimate);
  }
  const RunSummary summary = summarise(record);
  ASSERT_TRUE(summary.consistency);
  EXPECT_EQ(summary.consistency->updates, 4u);
  EXPECT_NEAR(summary.consistency->mean, 3.0, 1e-12);
  EXPECT_NEAR(summary.consistency->share_inside, 0.75, 1e-12);
  EXPECT_NEAR(summary.consistency->meanTolerance(), 1.96, 1e-12);
  ASSERT_TRUE(summary.converged_time);
  EXPECT_NEAR(*summary.converged_time, 20.0, 1e-9);
  EXPECT_FALSE(summarise(syntheticRecord(1'000)).consistency);
}

TEST(RunSummary, saysWhyThereIsNoDrift) {
  const RunSummary short_run = summarise(syntheticRecord(10'000));
  EXPECT_FALSE(short_run.before.harmonics);
  EXPECT_NE(short_run.before.missing.find("at least one is needed"), std::string::npos);
  const RunSummary unlocked = summarise(syntheticRecord(100));
  EXPECT_FALSE(unlocked.ring_up_time);
  EXPECT_FALSE(unlocked.loop_errors);
  EXPECT_EQ(summarise(RunRecord()).before.missing, "the run is empty");
}

TEST(RunRecord, takesTopicsInAnyOrderAndCountsWhatIsMissing) {
  RunRecord record;
  SyntheticRun run;
  std::vector<ControlGains> gains;
  for (; run.sequence() < 3000; run.next()) {
    gains.push_back(run.gains());
    if (run.sequence() >= 10 && run.sequence() != 2000) record.add(run.elements());
  }
  for (const ControlGains& one : gains) record.add(one);
  EXPECT_EQ(record.blocks().size(), 3000u);
  EXPECT_NEAR(record.time(record.blocks().front()), 1e-3, 1e-12);
  EXPECT_EQ(summarise(record).missing_blocks, 11u);
}

TEST(RunRecord, refusesASecondRun) {
  RunRecord record;
  SyntheticRun run;
  record.add(run.elements());
  OrbitalElements other = run.elements();
  other.stamp.session = 8;
  EXPECT_THROW(record.add(other), std::invalid_argument);
  other = run.elements();
  other.stamp.sequence = 1'000'000'000'000;
  EXPECT_THROW(record.add(other), std::invalid_argument);
}

}  // namespace
}  // namespace cvg
