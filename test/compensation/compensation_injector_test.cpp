#include "ring_gyro/compensation/compensation_injector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/control/drive_synthesis.h"
#include "ring_gyro/identification/model/averaged_model.h"
#include "ring_gyro/signals/compensation_decision.h"

namespace cvg {
namespace {

constexpr std::int64_t kPeriodBlocks = 100;
constexpr double kFrequency = 14e3;
constexpr double kQuality = 22000.0;
const DeviceKnowledge kKnown = {kFrequency, kQuality};
constexpr double kTrueDriveGain = 1.1e5;
constexpr double kGainPerGamma = kTwoPi * kFrequency / kQuality / kTrueDriveGain;

/// A good estimate at the end of period `period` (100 ms each).
ParameterEstimate good(std::uint64_t period, double gamma1 = 0.02, double gamma2 = 0.03) {
  ParameterEstimate estimate;
  estimate.stamp = {1, 100 * (period + 1) - 1, 1000000, 1000000};
  estimate.used_blocks = 100 * period;
  estimate.value << 1.0, 0.0, gamma1, gamma2, -30e-6, -40e-6, kTrueDriveGain;
  estimate.parameter_variance << 1e-10, 1e-10, 1e-20, 1e-20, 1.0;
  estimate.updated = true;
  estimate.converged = true;
  return estimate;
}

double length(const CompensationDecision& decision) {
  return std::hypot(decision.gamma1, decision.gamma2);
}

TEST(CompensationInjector, RefusesWhatItCannotUse) {
  EXPECT_THROW(CompensationInjector(kKnown, {}, 0), std::invalid_argument);
  const auto expectRefused = [](double InjectorParameters::*field, double value) {
    InjectorParameters parameters = InjectorParameters();
    parameters.*field = value;
    EXPECT_THROW(CompensationInjector(kKnown, parameters, kPeriodBlocks), std::invalid_argument)
        << value;
  };
  EXPECT_THROW(CompensationInjector({0.0, kQuality}, {}, kPeriodBlocks), std::invalid_argument);
  EXPECT_THROW(CompensationInjector({kFrequency, -1.0}, {}, kPeriodBlocks), std::invalid_argument);
  expectRefused(&InjectorParameters::ramp_rate, 0.0);
  expectRefused(&InjectorParameters::gamma_limit, 1.5);
  expectRefused(&InjectorParameters::start_after, -1.0);
  expectRefused(&InjectorParameters::gamma_sigma_limit, std::numeric_limits<double>::quiet_NaN());
}

TEST(CompensationInjector, DecidesOnePeriodAhead) {
  CompensationInjector injector(kKnown, {}, kPeriodBlocks);
  const CompensationDecision decision = injector.decide(good(5));
  EXPECT_EQ(decision.session, 1u);
  EXPECT_EQ(decision.data_sequence, 599u);
  EXPECT_EQ(decision.effective_sequence, 700u);
}

TEST(CompensationInjector, RampsStraightToTheEstimate) {
  CompensationInjector injector(kKnown, {}, kPeriodBlocks);  // 0.05 / s in steps of 100 ms
  const double target = std::hypot(0.02, 0.03);
  for (std::uint64_t k = 0; k < 12; ++k) {
    const CompensationDecision decision = injector.decide(good(k));
    EXPECT_EQ(decision.state, InjectorState::kTracking);
    EXPECT_NEAR(length(decision), std::min(0.005 * static_cast<double>(k + 1), target), 1e-15);
    EXPECT_NEAR(decision.gamma2 / decision.gamma1, 1.5, 1e-12);
    EXPECT_NEAR(decision.gains.gain1, kGainPerGamma * decision.gamma1, 1e-18);
    EXPECT_NEAR(decision.gains.gain2, kGainPerGamma * decision.gamma2, 1e-18);
  }
  // There it follows, with the drive gain of the estimate.
  ParameterEstimate estimate = good(12, 0.021, 0.029);
  estimate.value[kDriveGain] = 1.2e5;
  const CompensationDecision decision = injector.decide(estimate);
  EXPECT_DOUBLE_EQ(decision.gamma1, 0.021);
  EXPECT_NEAR(decision.gains.gain2, kGainPerGamma * 0.029 * 1.1 / 1.2, 1e-18);
}

TEST(CompensationInjector, WaitsBehindTheGate) {
  const auto expectWaiting = [](const ParameterEstimate& estimate, const char* why) {
    SCOPED_TRACE(why);
    InjectorParameters parameters = InjectorParameters();
    parameters.start_after = 2.0;
    CompensationInjector injector(kKnown, parameters, kPeriodBlocks);
    const CompensationDecision decision = injector.decide(estimate);
    EXPECT_EQ(decision.state, InjectorState::kWaiting);
    EXPECT_EQ(decision.gains.gain1, 0.0);
    EXPECT_EQ(decision.gains.gain2, 0.0);
    EXPECT_EQ(decision.gamma1, 0.0);
  };
  ParameterEstimate estimate = good(30);
  estimate.converged = false;
  expectWaiting(estimate, "not converged");
  estimate = good(30);
  estimate.parameter_variance[0] = 2.1e-4 * 2.1e-4;
  expectWaiting(estimate, "sigma of gamma1");
  estimate = good(30);
  estimate.parameter_variance[1] = 2.1e-4 * 2.1e-4;
  expectWaiting(estimate, "sigma of gamma2");
  expectWaiting(good(19), "1.9 s of data");
  estimate = good(30);
  estimate.value[kGamma1] = std::numeric_limits<double>::quiet_NaN();
  expectWaiting(estimate, "not a number");
  estimate = good(30);
  estimate.parameter_variance[3] = std::numeric_limits<double>::infinity();
  expectWaiting(estimate, "infinite variance");
  estimate = good(30);
  estimate.value[kDriveGain] = 0.0;
  expectWaiting(estimate, "no drive gain");

  InjectorParameters parameters = InjectorParameters();
  parameters.start_after = 2.0;
  CompensationInjector injector(kKnown, parameters, kPeriodBlocks);
  EXPECT_EQ(injector.decide(good(20)).state, InjectorState::kTracking);
}

TEST(CompensationInjector, KeepsWhatItHasWhenTheGateShuts) {
  CompensationInjector injector(kKnown, {}, kPeriodBlocks);
  const CompensationDecision open = injector.decide(good(0));
  ParameterEstimate doubtful = good(1);
  doubtful.converged = false;
  CompensationDecision decision = injector.decide(doubtful);
  EXPECT_EQ(decision.state, InjectorState::kWaiting);
  EXPECT_EQ(decision.gains.gain1, open.gains.gain1);
  doubtful.value.setConstant(std::numeric_limits<double>::quiet_NaN());
  decision = injector.decide(doubtful);
  EXPECT_EQ(decision.gains.gain1, open.gains.gain1);
  EXPECT_EQ(decision.gamma2, open.gamma2);
}

TEST(CompensationInjector, DoesNotFollowBeyondTheLimit) {
  CompensationInjector injector(kKnown, {}, kPeriodBlocks);
  for (std::uint64_t k = 0; k < 10; ++k) injector.decide(good(k));
  const CompensationDecision decision = injector.decide(good(10, 0.12, 0.1));
  EXPECT_EQ(decision.state, InjectorState::kLimited);
  EXPECT_DOUBLE_EQ(decision.gamma1, 0.02);
  EXPECT_DOUBLE_EQ(decision.gamma2, 0.03);
  EXPECT_NEAR(decision.gains.gain1, kGainPerGamma * 0.02, 1e-18);
  EXPECT_EQ(injector.decide(good(11)).state, InjectorState::kTracking);
}

TEST(CompensationInjector, HoldFreezes) {
  CompensationInjector injector(kKnown, {}, kPeriodBlocks);
  const CompensationDecision before = injector.decide(good(0));
  injector.setHold(true);
  ParameterEstimate other = good(1, -0.05, 0.01);
  other.value[kDriveGain] = 2e5;
  const CompensationDecision held = injector.decide(other);
  EXPECT_EQ(held.state, InjectorState::kHolding);
  EXPECT_EQ(held.gains.gain1, before.gains.gain1);
  EXPECT_EQ(held.gains.gain2, before.gains.gain2);
  injector.setHold(false);
  const CompensationDecision after = injector.decide(good(2));
  EXPECT_EQ(after.state, InjectorState::kTracking);
  EXPECT_NEAR(length(after), 0.010, 1e-15);
}

TEST(CompensationInjector, DisabledRampsToZeroEvenOnHold) {
  CompensationInjector injector(kKnown, {}, kPeriodBlocks);
  for (std::uint64_t k = 0; k < 3; ++k) injector.decide(good(k));
  injector.setHold(true);
  injector.setEnabled(false);
  for (std::uint64_t k = 3; k < 8; ++k) {
    const CompensationDecision decision = injector.decide(good(k));
    EXPECT_EQ(decision.state, InjectorState::kDisabled);
    EXPECT_NEAR(length(decision), std::max(0.0, 0.015 - 0.005 * static_cast<double>(k - 2)), 1e-15);
    EXPECT_NEAR(decision.gains.gain1, kGainPerGamma * decision.gamma1, 1e-18);
  }
  injector.setHold(false);
  injector.setEnabled(true);
  EXPECT_NEAR(length(injector.decide(good(8))), 0.005, 1e-15);
}

TEST(CompensationInjector, StartsDisabledWhenToldSo) {
  InjectorParameters parameters = InjectorParameters();
  parameters.enabled = false;
  CompensationInjector injector(kKnown, parameters, kPeriodBlocks);
  const CompensationDecision decision = injector.decide(good(50));
  EXPECT_EQ(decision.state, InjectorState::kDisabled);
  EXPECT_EQ(decision.gains.gain1, 0.0);
}

TEST(CompensationInjector, ResetIsAtOnce) {
  CompensationInjector injector(kKnown, {}, kPeriodBlocks);
  for (std::uint64_t k = 0; k < 10; ++k) injector.decide(good(k));
  injector.reset();
  ParameterEstimate waiting = good(10);
  waiting.converged = false;
  const CompensationDecision decision = injector.decide(waiting);
  EXPECT_EQ(decision.state, InjectorState::kWaiting);
  EXPECT_EQ(decision.gains.gain1, 0.0);
  EXPECT_EQ(decision.gains.gain2, 0.0);
  EXPECT_NEAR(length(injector.decide(good(11))), 0.005, 1e-15);
}

TEST(CompensationInjector, NewSessionBeginsAtZero) {
  CompensationInjector injector(kKnown, {}, kPeriodBlocks);
  for (std::uint64_t k = 0; k < 10; ++k) injector.decide(good(k));
  ParameterEstimate estimate = good(0);
  estimate.stamp.session = 2;
  const CompensationDecision decision = injector.decide(estimate);
  EXPECT_EQ(decision.session, 2u);
  EXPECT_NEAR(length(decision), 0.005, 1e-15);
}

TEST(CompensationInjector, NamesItsStates) {
  EXPECT_STREQ(toString(InjectorState::kDisabled), "disabled");
  EXPECT_STREQ(toString(InjectorState::kWaiting), "waiting");
  EXPECT_STREQ(toString(InjectorState::kTracking), "tracking");
  EXPECT_STREQ(toString(InjectorState::kHolding), "holding");
  EXPECT_STREQ(toString(InjectorState::kLimited), "limited");
}

/// Peak-to-peak of the drift theta' over a turn of the pattern, sustained at a = 1, b = 0, with the
/// compensation `sign` times what the injector decides [rad/s].
double driftUnder(double sign) {
  const DeviceParameters device{0.02, 0.03, 0.0, 0.0, kTrueDriveGain};
  CompensationInjector injector(kKnown, {}, kPeriodBlocks);
  CompensationDecision decision;
  for (std::uint64_t k = 0; k < 10; ++k) decision = injector.decide(good(k));
  const AveragedModel model({kFrequency, kQuality});
  DriveGains gains;
  gains.compensation.gain1 = sign * decision.gains.gain1;
  gains.compensation.gain2 = sign * decision.gains.gain2;
  double lowest = 0.0, highest = 0.0;
  for (int degree = 0; degree < 360; ++degree) {
    const Orbit orbit{1.0, 0.0, toRadians(degree), -kPi / 2};
    AveragedInput input;
    input.reference_frequency = kTwoPi * kFrequency;
    input.drive = synthesizeDrive(orbit, gains, input.reference_frequency, kTrueDriveGain).total();
    const double rate = model.rates(orbit, device, input).theta;
    lowest = std::min(lowest, rate);
    highest = std::max(highest, rate);
  }
  return highest - lowest;
}

// Equation (35) is printed with minus signs: with them the drift doubles instead of vanishing.
TEST(CompensationInjector, SignPrintedIn35DoublesTheDrift) {
  const double uncompensated = driftUnder(0.0);
  const double decay = AveragedModel({kFrequency, kQuality}).decayRate();
  EXPECT_NEAR(uncompensated, 2.0 * decay * std::hypot(0.02, 0.03), 1e-4 * uncompensated);
  EXPECT_LT(driftUnder(+1.0), 1e-12);
  EXPECT_NEAR(driftUnder(-1.0) / uncompensated, 2.0, 1e-9);
}

}  // namespace
}  // namespace cvg
