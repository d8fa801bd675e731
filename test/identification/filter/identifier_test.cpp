#include "ring_gyro/identification/filter/identifier.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "identification/averaged_loop.h"
#include "ring_gyro/compensation/compensation_injector.h"

namespace cvg {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const DeviceParameters kDevice = AveragedLoop::Options{}.device;
const DeviceKnowledge kKnown = AveragedLoop::Options{}.known;

IdentificationParameters parametersFor(double period = 0.1) {
  IdentificationParameters parameters;
  parameters.update_period = period;
  return parameters;
}

StateVector truth(const AveragedLoop& loop) {
  StateVector value;
  value << loop.orbit().a, loop.orbit().b, kDevice.gamma1, kDevice.gamma2, kDevice.mu1, kDevice.mu2,
      kDevice.drive_gain;
  return value;
}

/// Last estimate after `blocks` blocks of `loop`.
ParameterEstimate run(Identifier& identifier, AveragedLoop& loop, int blocks) {
  ParameterEstimate last;
  for (int n = 0; n < blocks; ++n) {
    const AveragedLoop::Output output = loop.step();
    if (const auto estimate = identifier.process(output.elements, output.gains)) last = *estimate;
  }
  return last;
}

void expectNear(const ParameterEstimate& estimate, double gamma, double mu, double drive_gain) {
  EXPECT_NEAR(estimate.value[kGamma1], kDevice.gamma1, gamma);
  EXPECT_NEAR(estimate.value[kGamma2], kDevice.gamma2, gamma);
  EXPECT_NEAR(estimate.value[kMu1], kDevice.mu1, mu);
  EXPECT_NEAR(estimate.value[kMu2], kDevice.mu2, mu);
  EXPECT_NEAR(estimate.value[kDriveGain] / kDevice.drive_gain, 1.0, drive_gain);
}

void expectFinite(const ParameterEstimate& estimate, const Identifier& identifier) {
  EXPECT_TRUE(estimate.value.allFinite());
  const StateMatrix covariance = identifier.covariance();
  EXPECT_TRUE(covariance.allFinite());
  EXPECT_GE(covariance.diagonal().minCoeff(), 0.0);
  EXPECT_EQ(covariance.diagonal().tail<5>(), estimate.parameter_variance);
  EXPECT_TRUE(estimate.innovation.allFinite());
  EXPECT_TRUE(estimate.innovation_covariance.allFinite());
  EXPECT_TRUE(std::isfinite(estimate.normalised_innovation_squared));
  EXPECT_TRUE(std::isfinite(estimate.residual_gamma1));
  EXPECT_TRUE(std::isfinite(estimate.residual_gamma2));
  EXPECT_TRUE(std::isfinite(estimate.angle_covered));
}

std::uint64_t accountedFor(const ParameterEstimate& estimate) {
  return estimate.used_blocks + estimate.rejected_blocks + estimate.lost_blocks;
}

TEST(Identifier, ACopyOfAnEstimateKeepsItsCovariance) {
  Identifier identifier(kKnown, parametersFor(), ConverterParameters{});
  AveragedLoop loop({});
  const ParameterEstimate early = run(identifier, loop, 1000);
  const StateMatrix then = identifier.covariance();
  EXPECT_EQ(early.covariance.matrix(), then);
  ParameterEstimate assigned;
  assigned = early;
  run(identifier, loop, 1000);
  EXPECT_LT(identifier.covariance()(kMu1, kMu1), then(kMu1, kMu1));
  EXPECT_EQ(early.covariance.matrix(), then);
  EXPECT_EQ(assigned.covariance.matrix(), then);
  EXPECT_EQ(assigned.covariance.matrix().diagonal().tail<5>(), assigned.parameter_variance);
}

TEST(Identifier, RefusesWhatItCannotUse) {
  const ConverterParameters converter;
  const auto with = [&](auto&& change) {
    DeviceKnowledge known = kKnown;
    IdentificationParameters parameters = parametersFor();
    change(known, parameters);
    return Identifier(known, parameters, converter);
  };
  EXPECT_NO_THROW(with([](auto&, auto&) {}));
  EXPECT_THROW(with([](auto& d, auto&) { d.natural_frequency = 0.0; }), std::invalid_argument);
  EXPECT_THROW(with([](auto& d, auto&) { d.quality_factor = kNan; }), std::invalid_argument);
  EXPECT_THROW(with([](auto&, auto& p) { p.update_period = 0.0015; }), std::invalid_argument);
  EXPECT_THROW(with([](auto&, auto& p) { p.update_period = 0.0; }), std::invalid_argument);
  EXPECT_THROW(with([](auto&, auto& p) { p.noise_density = 0.0; }), std::invalid_argument);
  EXPECT_THROW(with([](auto&, auto& p) { p.tuning = static_cast<Tuning>(7); }),
               std::invalid_argument);
  try {
    with([](auto&, auto& p) { p.gamma_walk = -1.0; });
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("gamma_walk"), std::string::npos) << error.what();
  }
  EXPECT_EQ(with([](auto&, auto& p) { p.update_period = 0.001; }).periodBlocks(), 1);
  EXPECT_EQ(with([](auto&, auto&) {}).periodBlocks(), 100);
}

// Without noise. Inputs that are wrong in time by a microsecond would already fail.
TEST(Identifier, RecoversTheDeviceAtAnyGroupDelay) {
  for (const double delay : {0.0, 0.2e-3, 0.6275e-3, 1.0e-3, 1.75e-3}) {
    SCOPED_TRACE(delay);
    AveragedLoop::Options options;
    options.group_delay = delay;
    AveragedLoop loop(options);
    Identifier identifier(kKnown, parametersFor(), ConverterParameters{});
    const ParameterEstimate estimate = run(identifier, loop, 60000);
    expectNear(estimate, 5e-9, 8e-12, 1e-8);
    EXPECT_TRUE(estimate.updated);
    EXPECT_TRUE(estimate.converged);
  }
}

TEST(Identifier, WrongGroupDelayShows) {
  AveragedLoop::Options options;
  options.group_delay = 0.6275e-3;
  AveragedLoop loop(options);
  Identifier identifier(kKnown, parametersFor(), ConverterParameters{});
  ParameterEstimate last;
  for (int n = 0; n < 60000; ++n) {
    AveragedLoop::Output output = loop.step();
    output.elements.group_delay += 10e-6;
    if (const auto estimate = identifier.process(output.elements, output.gains)) last = *estimate;
  }
  EXPECT_NEAR(last.value[kGamma1] - kDevice.gamma1, 1.2e-7, 0.2e-7);
  EXPECT_NEAR(last.value[kMu1] - kDevice.mu1, -1.5e-10, 0.2e-10);
}

TEST(Identifier, SaysHowWellItKnowsWhatItFound) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    AveragedLoop::Options options;
    options.group_delay = 0.6275e-3;
    options.noise_density = 5e-6;
    options.seed = seed;
    AveragedLoop loop(options);
    Identifier identifier(kKnown, parametersFor(), ConverterParameters{});
    const ParameterEstimate estimate = run(identifier, loop, 60000);
    expectNear(estimate, 5e-6, 3e-10, 5e-6);
    EXPECT_LT(estimate.sigma(kGamma1), 1.5e-6);
    EXPECT_LT(estimate.sigma(kMu1), 1e-10);
    EXPECT_LT(estimate.sigma(kDriveGain) / kDevice.drive_gain, 1e-6);
  }
}

// The normalised squared error of the five parameters is chi squared with 5 degrees of freedom for
// each independent run. 25 runs: 125 +- 16; three sigmas are allowed.
TEST(Identifier, ErrorsAreAsLargeAsItsCovarianceSays) {
  double sum = 0.0;
  double innovations = 0.0;
  int periods = 0;
  const int runs = 25;
  for (int k = 0; k < runs; ++k) {
    AveragedLoop::Options options;
    options.group_delay = 0.6275e-3;
    options.noise_density = 5e-6;
    options.seed = 100u + static_cast<unsigned>(k);
    AveragedLoop loop(options);
    IdentificationParameters parameters = parametersFor();
    parameters.axis_process_noise = 1e-8;
    Identifier identifier(kKnown, parameters, ConverterParameters{});
    ParameterEstimate last;
    for (int n = 0; n < 10000; ++n) {
      const AveragedLoop::Output output = loop.step();
      if (const auto estimate = identifier.process(output.elements, output.gains)) {
        last = *estimate;
        if (n > 3000) {
          innovations += last.normalised_innovation_squared;
          ++periods;
        }
      }
    }
    const Eigen::Matrix<double, 5, 1> error = (last.value - truth(loop)).tail<5>();
    const Eigen::Matrix<double, 5, 1> scale = last.parameter_variance.cwiseSqrt();
    const Eigen::Matrix<double, 5, 5> correlation =
        scale.asDiagonal().inverse() * identifier.covariance().bottomRightCorner<5, 5>() *
        scale.asDiagonal().inverse();
    const Eigen::Matrix<double, 5, 1> scaled = error.cwiseQuotient(scale);
    sum += scaled.dot(correlation.ldlt().solve(scaled));
  }
  EXPECT_NEAR(sum, 5.0 * runs, 3.0 * std::sqrt(10.0 * runs));
  EXPECT_NEAR(innovations / periods, 2.0, 3.0 * 2.0 / std::sqrt(periods));
}

TEST(Identifier, PeriodsOfOneBlockAndOfAHundredAgree) {
  AveragedLoop::Options options;
  options.group_delay = 0.6275e-3;
  options.noise_density = 5e-6;
  AveragedLoop loop(options);
  Identifier fast(kKnown, parametersFor(0.001), ConverterParameters{});
  Identifier slow(kKnown, parametersFor(0.1), ConverterParameters{});
  ParameterEstimate each_block, each_period;
  for (int n = 0; n < 60000; ++n) {
    const AveragedLoop::Output output = loop.step();
    if (const auto estimate = fast.process(output.elements, output.gains)) each_block = *estimate;
    if (const auto estimate = slow.process(output.elements, output.gains)) each_period = *estimate;
  }
  // The slower filter starts 100 ms later and gives all samples of a period the same weight.
  for (int k = kGamma1; k <= kDriveGain; ++k) {
    const auto state = static_cast<StateIndex>(k);
    EXPECT_NEAR(each_block.value[k], each_period.value[k], 0.15 * each_period.sigma(state)) << k;
    EXPECT_NEAR(each_block.sigma(state) / each_period.sigma(state), 1.0, 0.01) << k;
  }
}

TEST(Identifier, CompensationAndSteeringAreKnownInputs) {
  AveragedLoop::Options options;
  options.group_delay = 0.6275e-3;
  options.virtual_rate = toRadians(-20.0);
  options.rotation_rate = toRadians(5.0);
  AveragedLoop loop(options);
  Identifier identifier(kKnown, parametersFor(), ConverterParameters{});
  run(identifier, loop, 20000);
  const double per_gamma = 2.0 * kKnown.decayRate() / kDevice.drive_gain;
  loop.setCompensation({per_gamma * kDevice.gamma1, per_gamma * 0.5 * kDevice.gamma2});
  const ParameterEstimate estimate = run(identifier, loop, 40000);
  expectNear(estimate, 1e-8, 1e-11, 1e-8);
  EXPECT_NEAR(estimate.residual_gamma1, 0.0, 2e-8);
  EXPECT_NEAR(estimate.residual_gamma2, 0.5 * kDevice.gamma2, 2e-8);
}

TEST(Identifier, EmitsAtThePeriodsEndWheneverItStarted) {
  AveragedLoop loop{AveragedLoop::Options{}};
  for (int n = 0; n < 37; ++n) loop.step();
  Identifier identifier(kKnown, parametersFor(), ConverterParameters{});
  std::vector<std::uint64_t> ends;
  std::vector<bool> updated;
  for (int n = 37; n < 500; ++n) {
    const AveragedLoop::Output output = loop.step();
    if (const auto estimate = identifier.process(output.elements, output.gains)) {
      ends.push_back(estimate->stamp.sequence);
      updated.push_back(estimate->updated);
      EXPECT_EQ(estimate->first_sequence, 37u);
      EXPECT_EQ(accountedFor(*estimate), estimate->stamp.sequence - 37 + 1);
      expectFinite(*estimate, identifier);
    }
  }
  EXPECT_EQ(ends, (std::vector<std::uint64_t>{99, 199, 299, 399, 499}));
  // 37..99 is not a whole period, 100..199 sets the scale of ks.
  EXPECT_EQ(updated, (std::vector<bool>{false, false, true, true, true}));
}

/// Runs 40 s, applies `harm` to each block and checks that the estimates stay right and finite. The
/// first period cannot be used: its first elements reach back, by the group delay, to before the
/// first block.
constexpr std::uint64_t kFirstPeriod = 100;

template <typename Harm>
ParameterEstimate runHarmed(Harm&& harm) {
  AveragedLoop::Options options;
  options.group_delay = 0.6275e-3;
  AveragedLoop loop(options);
  Identifier identifier(kKnown, parametersFor(), ConverterParameters{});
  ParameterEstimate last;
  for (int n = 0; n < 40000; ++n) {
    AveragedLoop::Output output = loop.step();
    if (!harm(n, output)) continue;
    if (const auto estimate = identifier.process(output.elements, output.gains)) {
      expectFinite(*estimate, identifier);
      last = *estimate;
    }
  }
  EXPECT_EQ(accountedFor(last), 40000u);
  expectNear(last, 1e-8, 1e-11, 1e-8);
  return last;
}

TEST(Identifier, GapsCostTheirPeriodsOnly) {
  const ParameterEstimate estimate = runHarmed([](int n, AveragedLoop::Output&) {
    const bool lost = n % 5000 == 1234 || (n >= 20090 && n < 20310);
    return !lost;
  });
  EXPECT_EQ(estimate.lost_blocks, 8u + 220u);
  // Each of the eight single losses costs the rest of its period, the long one 90 blocks on each
  // side.
  EXPECT_EQ(estimate.rejected_blocks, kFirstPeriod + 8u * 99u + 90u + 90u);
  EXPECT_EQ(estimate.used_blocks, 40000u - estimate.lost_blocks - estimate.rejected_blocks);
}

TEST(Identifier, UnusableBlocksBreakTheChain) {
  const ParameterEstimate estimate = runHarmed([](int n, AveragedLoop::Output& output) {
    if (n % 10000 == 4050) output.elements.status.invalid_samples = true;
    if (n % 10000 == 5050) output.gains.status.drive_saturated = true;
    if (n % 10000 == 6050) output.elements.status.phase_locked = false;
    if (n % 10000 == 7050) output.elements.status.converter_saturated = true;
    return true;
  });
  EXPECT_EQ(estimate.rejected_blocks, kFirstPeriod + 16u * 100u);
}

TEST(Identifier, ElementsThatStillHoldABadBlockAreNotUsed) {
  // The first elements of a period still depend on the last block of the period before.
  const ParameterEstimate estimate = runHarmed([](int n, AveragedLoop::Output& output) {
    if (n == 9999) output.elements.status.invalid_samples = true;
    return true;
  });
  EXPECT_EQ(estimate.rejected_blocks, kFirstPeriod + 200u);
}

TEST(Identifier, NothingThatIsNotANumberGetsIn) {
  const double infinity = std::numeric_limits<double>::infinity();
  const ParameterEstimate estimate = runHarmed([&](int n, AveragedLoop::Output& output) {
    if (n == 50) output.elements.orbit.a = kNan;
    if (n == 1050) output.elements.orbit.a = kNan;
    if (n == 2050) output.elements.orbit.b = infinity;
    if (n == 3050) output.elements.orbit.theta = kNan;
    if (n == 4050) output.elements.orbit.phi = -infinity;
    if (n == 5050) output.elements.group_delay = kNan;
    if (n == 6050) output.gains.drive.steering[1] = {0.0, kNan};
    if (n == 7050) output.gains.reference_frequency = kNan;
    if (n == 8050) output.gains.reference_frequency = 0.0;
    if (n == 9099) output.gains.compensation.gain1 = kNan;
    if (n == 10050) output.elements.orbit.a = 1e300;
    if (n == 11050) output.elements.orbit.a = 0.0;
    if (n == 12050) output.elements.orbit.a = -1.0;
    if (n == 13050) output.elements.group_delay = 1e9;
    if (n == 14050) output.elements.group_delay = -1e-3;
    return true;
  });
  // The first bad block is in the first period; the one at a period's end also costs the next
  // period.
  EXPECT_EQ(estimate.rejected_blocks, kFirstPeriod + 14u * 100u + 100u);
}

TEST(Identifier, DriveThatDoesNotSustainSetsNoScale) {
  const ParameterEstimate estimate = runHarmed([](int n, AveragedLoop::Output& output) {
    if (n < 200) output.gains.drive.sustain *= -1.0;
    return true;
  });
  EXPECT_EQ(estimate.rejected_blocks, kFirstPeriod + 100u);
}

// Absurd data that are marked usable spoil the estimate, but all its numbers stay finite.
TEST(Identifier, StaysFiniteWhateverItIsTold) {
  for (const double size : {1e3, 1e7, 1e11}) {
    AveragedLoop loop{AveragedLoop::Options{}};
    Identifier identifier(kKnown, parametersFor(), ConverterParameters{});
    for (int n = 0; n < 5000; ++n) {
      AveragedLoop::Output output = loop.step();
      if (n > 100 && n % 700 < 150) output.elements.orbit.a *= size;
      if (n > 1000 && n % 900 < 250) output.gains.drive.quadrature *= size;
      if (n > 2000 && n % 1100 < 350) output.elements.orbit.theta *= size;
      if (const auto estimate = identifier.process(output.elements, output.gains)) {
        expectFinite(*estimate, identifier);
      }
    }
  }
}

TEST(Identifier, StampsMustFollowEachOther) {
  const ParameterEstimate estimate = runHarmed([](int n, AveragedLoop::Output& output) {
    if (n == 2050) output.gains.stamp.sequence += 1;
    if (n == 3050) output.gains.stamp.session += 1;
    if (n == 4050) output.elements.stamp.end_ns = 0;
    if (n == 5050) output.elements.stamp.duration_ns += 1;
    if (n >= 6050) output.elements.stamp.end_ns += 250000;  // the clock jumps once
    return true;
  });
  EXPECT_EQ(estimate.rejected_blocks, kFirstPeriod + 500u);
}

TEST(Identifier, ParametersOutlastABreakAndTheAxesDoNot) {
  AveragedLoop loop{AveragedLoop::Options{}};
  Identifier identifier(kKnown, parametersFor(), ConverterParameters{});
  const ParameterEstimate before = run(identifier, loop, 20000);
  const StateMatrix covariance = identifier.covariance();
  ParameterEstimate broken;
  for (int n = 0; n < 100; ++n) {
    AveragedLoop::Output output = loop.step();
    if (n == 30) output.elements.status.phase_locked = false;
    if (const auto estimate = identifier.process(output.elements, output.gains)) broken = *estimate;
  }
  EXPECT_FALSE(broken.updated);
  EXPECT_EQ(broken.value.tail<5>(), before.value.tail<5>());
  EXPECT_EQ(broken.parameter_variance, before.parameter_variance);
  EXPECT_EQ((identifier.covariance().bottomRightCorner<5, 5>()),
            (covariance.bottomRightCorner<5, 5>()));
  EXPECT_TRUE((identifier.covariance().topRightCorner<2, 5>().isZero(0.0)));
  EXPECT_GT(identifier.covariance()(kA, kA), 1e-6);
  const ParameterEstimate after = run(identifier, loop, 100);
  EXPECT_TRUE(after.updated);
  EXPECT_LT(identifier.covariance()(kA, kA), 1e-8);
  for (int k = 0; k < 5; ++k) {
    EXPECT_LE(after.parameter_variance[k], before.parameter_variance[k]) << k;
  }
}

TEST(Identifier, NewSessionStartsAfresh) {
  AveragedLoop loop{AveragedLoop::Options{}};
  Identifier identifier(kKnown, parametersFor(), ConverterParameters{});
  run(identifier, loop, 10000);
  AveragedLoop::Options options;
  options.session = 2;
  AveragedLoop second(options);
  const ParameterEstimate estimate = run(identifier, second, 100);
  EXPECT_EQ(identifier.restarts(), 1u);
  EXPECT_EQ(estimate.stamp.session, 2u);
  EXPECT_EQ(estimate.first_sequence, 0u);
  EXPECT_EQ(estimate.used_blocks, 100u);
  EXPECT_FALSE(estimate.updated);
  EXPECT_FALSE(estimate.converged);
  EXPECT_EQ(estimate.sigma(kGamma1), 0.1);

  // After that the results are those of a new identifier, to the last bit.
  Identifier fresh(kKnown, parametersFor(), ConverterParameters{});
  AveragedLoop again(options);
  const ParameterEstimate continued = run(identifier, second, 4900);
  const ParameterEstimate repeated = run(fresh, again, 5000);
  EXPECT_EQ(continued.value, repeated.value);
  EXPECT_EQ(continued.parameter_variance, repeated.parameter_variance);
  EXPECT_EQ(identifier.covariance(), fresh.covariance());
  EXPECT_EQ(identifier.covariance().diagonal().tail<5>(), continued.parameter_variance);
  EXPECT_EQ(fresh.restarts(), 0u);
}

TEST(Identifier, SequenceThatDoesNotGrowStartsAfresh) {
  AveragedLoop loop{AveragedLoop::Options{}};
  Identifier identifier(kKnown, parametersFor(), ConverterParameters{});
  run(identifier, loop, 1000);
  AveragedLoop looped{AveragedLoop::Options{}};  // a bag played in a loop: same session, from zero
  const ParameterEstimate estimate = run(identifier, looped, 1000);
  EXPECT_EQ(identifier.restarts(), 1u);
  EXPECT_EQ(estimate.used_blocks, 1000u);
  const AveragedLoop::Output output = looped.step();
  identifier.process(output.elements, output.gains);
  identifier.process(output.elements, output.gains);
  EXPECT_EQ(identifier.restarts(), 2u);
}

TEST(Identifier, ConvergedNeedsTheAngle) {
  IdentificationParameters parameters = parametersFor();
  parameters.converged_gamma_sigma = 1.0;
  parameters.converged_mu_sigma = 1.0;
  parameters.converged_drive_gain_sigma = 1.0;
  AveragedLoop loop{AveragedLoop::Options{}};
  Identifier identifier(kKnown, parameters, ConverterParameters{});
  double angle_at_convergence = 0.0;
  for (int n = 0; n < 30000 && angle_at_convergence == 0.0; ++n) {
    const AveragedLoop::Output output = loop.step();
    const auto estimate = identifier.process(output.elements, output.gains);
    if (estimate && estimate->converged) angle_at_convergence = estimate->angle_covered;
  }
  EXPECT_GE(angle_at_convergence, kPi);
  EXPECT_LT(angle_at_convergence, kPi + 0.05);

  // A pattern at rest never converges, however long the run.
  AveragedLoop::Options options;
  options.virtual_rate = 0.0;
  options.device = {0.0, 0.0, 0.0, 0.0, 1.1e5};
  AveragedLoop standing(options);
  Identifier patient(kKnown, parametersFor(), ConverterParameters{});
  const ParameterEstimate estimate = run(patient, standing, 30000);
  EXPECT_FALSE(estimate.converged);
  EXPECT_LT(estimate.angle_covered, 0.01);
  EXPECT_GT(estimate.sigma(kGamma1), 0.01);
}

TEST(Identifier, SigmaLimitsHoldConvergenceBack) {
  const auto convergedWith = [](double gamma, double mu, double drive_gain) {
    IdentificationParameters parameters = parametersFor();
    parameters.converged_gamma_sigma = gamma;
    parameters.converged_mu_sigma = mu;
    parameters.converged_drive_gain_sigma = drive_gain;
    AveragedLoop loop{AveragedLoop::Options{}};
    Identifier identifier(kKnown, parameters, ConverterParameters{});
    return run(identifier, loop, 20000).converged;
  };
  EXPECT_TRUE(convergedWith(1e-4, 1e-8, 5e-4));
  EXPECT_FALSE(convergedWith(1e-7, 1e-8, 5e-4));
  EXPECT_FALSE(convergedWith(1e-4, 1e-12, 5e-4));
  EXPECT_FALSE(convergedWith(1e-4, 1e-8, 1e-8));
}

TEST(Identifier, FollowsAParameterThatWalks) {
  IdentificationParameters parameters = parametersFor();
  parameters.gamma_walk = 1e-4;
  AveragedLoop loop{AveragedLoop::Options{}};
  Identifier constant(kKnown, parametersFor(), ConverterParameters{});
  Identifier walking(kKnown, parameters, ConverterParameters{});
  ParameterEstimate settled, following;
  for (int n = 0; n < 60000; ++n) {
    const AveragedLoop::Output output = loop.step();
    if (const auto estimate = constant.process(output.elements, output.gains)) settled = *estimate;
    if (const auto estimate = walking.process(output.elements, output.gains)) following = *estimate;
  }
  expectNear(following, 1e-6, 1e-10, 1e-6);
  EXPECT_GT(following.sigma(kGamma1), 10.0 * settled.sigma(kGamma1));
}

// The Q and R printed in the paper, without noise in the data: slow, and never converged.
TEST(Identifier, PaperTuningIsSlow) {
  IdentificationParameters parameters = parametersFor();
  parameters.tuning = Tuning::kPaper;
  AveragedLoop loop{AveragedLoop::Options{}};
  Identifier identifier(kKnown, parameters, ConverterParameters{});
  const auto gammaError = [](const ParameterEstimate& estimate) {
    return std::hypot(estimate.value[kGamma1] - kDevice.gamma1,
                      estimate.value[kGamma2] - kDevice.gamma2);
  };
  const ParameterEstimate minute = run(identifier, loop, 60000);
  EXPECT_GT(gammaError(minute), 0.1 * kDevice.gamma1);
  EXPECT_LT(gammaError(minute), 2.0 * kDevice.gamma1);
  const ParameterEstimate later = run(identifier, loop, 120000);
  EXPECT_LT(gammaError(later), 0.5 * gammaError(minute));
  EXPECT_GT(gammaError(later), 1e-4);
  EXPECT_FALSE(later.converged);
  expectFinite(later, identifier);
}

}  // namespace
}  // namespace cvg
