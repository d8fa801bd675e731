#include "ring_gyro/identification/filter/interval_filter.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "identification/averaged_loop.h"
#include "identification/recorded_loop.h"
#include "ring_gyro/common/angle.h"
#include "ring_gyro/identification/filter/paper_filter.h"

namespace cvg {
namespace {

constexpr double kStep = RecordedLoop::kStep;
const DeviceKnowledge kKnown = RecordedLoop::known();
const DeviceParameters kDevice = AveragedLoop::Options{}.device;
const ParameterVector kNoWalk = ParameterVector::Zero();

std::vector<RecordedStep> recordLoop(std::size_t steps, double noise_density, unsigned seed = 1) {
  return RecordedLoop(noise_density, seed).next(steps);
}

IntervalNoise noiseOf(double density, double process) {
  return RecordedLoop::noise(density, process);
}

StateVector startValue() { return RecordedLoop::startValue(); }
StateVector startSigma() { return RecordedLoop::startSigma(); }

IntervalFilter filterWith(const IntervalNoise& noise) {
  return IntervalFilter(AveragedModel(kKnown), noise, kStep);
}

/// The paper's filter with means as measurements, in long double: its seven states, and the running
/// sums of a and b as two more.
class MeanReference {
 public:
  using Real = long double;
  using Vector = Eigen::Matrix<Real, 9, 1>;
  using Matrix = Eigen::Matrix<Real, 9, 9>;

  MeanReference(const IntervalNoise& noise, const StateVector& value, const StateVector& sigma)
      : filter_(kKnown, noise, value, sigma), noise_(noise) {
    value_.setZero();
    value_.head<7>() = filter_.value();
    covariance_.setZero();
    covariance_.topLeftCorner<7, 7>() = filter_.covariance();
  }

  void step(const RecordedStep& record) {
    const PaperFilter<Real>::Step f =
        filter_.step(value_.head<7>(), record.theta, record.phi, record.input, kStep);
    value_.head<7>() = f.after;
    Matrix transition = Matrix::Identity();
    transition.topLeftCorner<7, 7>() = f.jacobian;
    Matrix process = Matrix::Zero();
    process.topLeftCorner<7, 7>() = f.noise;
    covariance_ = (transition * covariance_ * transition.transpose() + process).eval();

    Matrix add = Matrix::Identity();
    add.block<2, 2>(7, 0).setIdentity();
    value_ = (add * value_).eval();
    covariance_ = (add * covariance_ * add.transpose()).eval();
    measured_ += record.measured.cast<Real>();
    ++samples_;
  }

  Real update() {
    const Real share = Real(1) / samples_;
    Eigen::Matrix<Real, 2, 9> h = Eigen::Matrix<Real, 2, 9>::Zero();
    h(0, 7) = h(1, 8) = share;
    const Eigen::Matrix<Real, 2, 2> s =
        h * covariance_ * h.transpose() +
        share * Real(noise_.sample_variance) * Eigen::Matrix<Real, 2, 2>::Identity();
    const Eigen::Matrix<Real, 9, 2> gain = covariance_ * h.transpose() * s.inverse();
    const Eigen::Matrix<Real, 2, 1> innovation = share * measured_ - h * value_;
    value_ += gain * innovation;
    const Matrix rest = Matrix::Identity() - gain * h;
    covariance_ = (rest * covariance_ * rest.transpose() +
                   share * Real(noise_.sample_variance) * gain * gain.transpose())
                      .eval();
    // The sums start again from zero.
    value_.tail<2>().setZero();
    covariance_.bottomRows<2>().setZero();
    covariance_.rightCols<2>().setZero();
    measured_.setZero();
    samples_ = 0;
    return innovation.dot(s.inverse() * innovation);
  }

  Eigen::Matrix<Real, 7, 1> value() const { return value_.head<7>(); }
  Eigen::Matrix<Real, 7, 7> covariance() const { return covariance_.topLeftCorner<7, 7>(); }

 private:
  PaperFilter<Real> filter_;
  IntervalNoise noise_;
  Vector value_;
  Matrix covariance_;
  Eigen::Matrix<Real, 2, 1> measured_ = Eigen::Matrix<Real, 2, 1>::Zero();
  int samples_ = 0;
};

void take(IntervalFilter& filter, const RecordedStep& record) {
  filter.step(averagedStep(record.theta, record.phi, record.input), record.measured);
}

const IntervalUpdate& takeAndUpdate(IntervalFilter& filter, const RecordedStep& record) {
  return filter.stepAndUpdate(averagedStep(record.theta, record.phi, record.input),
                              record.measured);
}

/// Largest differences between filter and reference at the end of an interval.
struct WorstErrors {
  double value = 0.0;  // in sigmas
  double sigma = 0.0;
  double normalised_innovation_squared = 0.0;

  void add(const IntervalFilter& filter, const MeanReference& reference, double nis) {
    const StateMatrix covariance = filter.covariance();
    for (int k = 0; k < 7; ++k) {
      const double true_sigma = std::sqrt(static_cast<double>(reference.covariance()(k, k)));
      const double off = static_cast<double>(filter.value()[k] - reference.value()[k]);
      value = std::max(value, std::abs(off) / true_sigma);
      sigma = std::max(sigma, std::abs(std::sqrt(covariance(k, k)) / true_sigma - 1.0));
    }
    const double own = filter.lastUpdate().normalised_innovation_squared;
    normalised_innovation_squared =
        std::max(normalised_innovation_squared, std::abs(own - nis) / (1.0 + nis));
  }
};

void expectAgreement(std::size_t steps) {
  for (const int period : {1, 10, 100}) {
    for (const bool in_one : {false, true}) {
      if (in_one && period != 1) continue;
      SCOPED_TRACE(std::to_string(period) + (in_one ? ", in one" : ""));
      const std::vector<RecordedStep> records = recordLoop(steps, 5e-6);
      const IntervalNoise noise = noiseOf(5e-6, 2e-6);
      IntervalFilter filter = filterWith(noise);
      filter.initialise(startValue(), startSigma(), kNoWalk);
      MeanReference reference(noise, startValue(), startSigma());
      WorstErrors worst;
      for (std::size_t n = 0; n < records.size(); ++n) {
        reference.step(records[n]);
        if (in_one) {
          ASSERT_TRUE(takeAndUpdate(filter, records[n]).accepted);
        } else {
          take(filter, records[n]);
          filter.settle();  // each step by itself, also its derivatives
          if ((n + 1) % static_cast<std::size_t>(period) != 0) continue;
          ASSERT_TRUE(filter.update().accepted);
        }
        worst.add(filter, reference, static_cast<double>(reference.update()));
      }
      EXPECT_LT(worst.value, 1e-6);
      EXPECT_LT(worst.sigma, 1e-8);
      EXPECT_LT(worst.normalised_innovation_squared, 1e-7);
    }
  }
}

// Each step is predicted by itself, but the derivatives are those of one step over up to 8: the
// estimates differ only by their weights, by less than a thousandth. `steps`: whole hundreds.
void expectAgreementSideBySide(std::size_t steps) {
  const std::vector<RecordedStep> records = recordLoop(steps, 5e-6);
  const IntervalNoise noise = noiseOf(5e-6, 2e-6);
  IntervalFilter filter = filterWith(noise);
  StateVector sigma;
  sigma << 1e-3, 1e-3, 1e-3, 1e-3, 1e-8, 1e-8, 100.0;
  StateVector value;
  value << 1.0, 0.0, 0.0201, 0.0301, -30.01e-6, -40.01e-6, 1.1e5;
  filter.initialise(value, sigma, kNoWalk);
  MeanReference reference(noise, value, sigma);
  WorstErrors worst;
  for (std::size_t n = 0; n < records.size(); n += 100) {
    for (std::size_t k = 0; k < 100; ++k) {
      take(filter, records[n + k]);
      reference.step(records[n + k]);
    }
    ASSERT_TRUE(filter.update().accepted);
    worst.add(filter, reference, static_cast<double>(reference.update()));
  }
  testing::Test::RecordProperty("worst_value_in_sigmas", std::to_string(worst.value));
  EXPECT_LT(worst.value, 2e-3);
  EXPECT_LT(worst.sigma, 1e-3);
  EXPECT_LT(worst.normalised_innovation_squared, 2e-3);
}

TEST(IntervalFilter, AgreesWithADenseFilterInLongDouble) { expectAgreement(30000); }

TEST(IntervalFilter, TakesStepsSideBySide) { expectAgreementSideBySide(30000); }

// As far as an emulated processor gets, where long double may be 128 bits of software.
TEST(IntervalFilter, AgreesOverTheFirstSteps) {
  expectAgreement(300);
  expectAgreementSideBySide(300);
}

// A ring without dynamics, so the noise of end and mean has a closed form: from a known start,
// S = q h (n + 1)(2 n + 1) / (6 n) + R / n for the mean of a random walk at n times.
TEST(IntervalFilter, ProcessNoiseEntersMeanAndEndAsItShould) {
  const double density = 1e-3;
  const double process = 0.5;
  for (const int run : {1, 2, 7, 31, 32, 33, 100, -1, -2, -7, -100}) {
    SCOPED_TRACE(run);
    const int samples = std::abs(run);
    const bool each_by_itself = run < 0;
    IntervalNoise noise;
    noise.sample_variance = density * density / kStep;
    noise.axes_density = process * process;
    IntervalFilter filter(AveragedModel({kKnown.natural_frequency, 1e18}), noise, kStep);
    StateVector value = StateVector::Zero();
    value[kA] = 1.0;
    value[kDriveGain] = 1e5;
    filter.initialise(value, StateVector::Zero(), kNoWalk);
    AveragedInput input;
    input.reference_frequency = kTwoPi * kKnown.natural_frequency;
    for (int n = 0; n < samples; ++n) {
      filter.step(averagedStep(0.3, -kPi / 2, input), {1.5, 0.25});
      if (each_by_itself) filter.settle();
    }
    const IntervalUpdate update = filter.update();
    const double n = samples;
    const double end = noise.axes_density * kStep * n;
    const double mean = end * (n + 1.0) * (2.0 * n + 1.0) / (6.0 * n * n);
    const double cross = end * (n + 1.0) / (2.0 * n);
    const double s = mean + noise.sample_variance / n;
    EXPECT_NEAR(update.innovation_covariance(0, 0), s, 1e-12 * s);
    EXPECT_NEAR(update.innovation_covariance(0, 1), 0.0, 1e-12 * s);
    EXPECT_NEAR(update.innovation[0], 0.5, 1e-12);
    EXPECT_NEAR(update.normalised_innovation_squared, (0.25 + 0.0625) / s, 1e-10 / s);
    EXPECT_NEAR(filter.value()[kA], 1.0 + cross / s * 0.5, 1e-12);
    EXPECT_NEAR(filter.value()[kB], cross / s * 0.25, 1e-12);
    EXPECT_NEAR(filter.covariance()(kB, kB), end - cross * cross / s, 1e-12 * end);
  }
}

TEST(IntervalFilter, ParametersWalk) {
  IntervalFilter filter = filterWith(noiseOf(1.0, 0.0));
  ParameterVector walk;
  walk << 1e-3, 2e-3, 3e-7, 4e-7, 50.0;
  StateVector sigma = StateVector::Zero();
  sigma.head<2>().setConstant(1e-9);
  filter.initialise(startValue(), sigma, walk);
  const std::vector<RecordedStep> records = recordLoop(100, 0.0);
  for (int period = 0; period < 4; ++period) {
    for (const RecordedStep& record : records) {
      take(filter, record);
    }
    ASSERT_TRUE(filter.update().accepted);
  }
  // Measurements with this much noise show nothing: the sigmas are those of 0.4 s of random walk.
  for (int k = 0; k < 5; ++k) {
    EXPECT_NEAR(std::sqrt(filter.covariance()(k + 2, k + 2)), walk[k] * std::sqrt(0.4),
                1e-3 * walk[k]);
  }
}

// At one angle the data show two combinations of the five parameters. The others must not become
// less certain, however long the pattern rests there.
TEST(IntervalFilter, ForgetsOnlyWhatNewerDataShow) {
  IntervalFilter filter = filterWith(noiseOf(5e-6, 2e-6));
  StateVector sigma;
  sigma << 1e-6, 1e-6, 1e-5, 1e-5, 1e-9, 1e-9, 1.0;
  filter.initialise(startValue(), sigma, kNoWalk, 5.0);
  const std::vector<RecordedStep> records = recordLoop(100, 0.0);
  const double theta = 0.3;
  AveragedInput input = records.front().input;
  StateVector before;
  for (int period = 0; period < 3000; ++period) {
    for (int block = 0; block < 100; ++block) {
      filter.step(averagedStep(theta, -0.5 * 3.14159265358979, input), filter.value().head<2>());
    }
    ASSERT_TRUE(filter.update().accepted);
    if (period == 99) before = filter.covariance().diagonal();
  }
  const StateVector after = filter.covariance().diagonal();
  for (int k = kGamma1; k <= kDriveGain; ++k) {
    EXPECT_LT(after[k], 1.01 * before[k]) << k;
    EXPECT_GT(after[k], 0.0) << k;
  }
}

TEST(IntervalFilter, RestartedAxesAreCorrelatedWithNothing) {
  IntervalFilter filter = filterWith(noiseOf(5e-6, 2e-6));
  filter.initialise(startValue(), startSigma(), kNoWalk);
  for (const RecordedStep& record : recordLoop(100, 5e-6)) {
    take(filter, record);
  }
  filter.update();
  const StateMatrix before = filter.covariance();
  filter.restartAxes({0.9, 0.01}, 0.02);
  const StateMatrix after = filter.covariance();
  EXPECT_EQ((after.bottomRightCorner<5, 5>()), (before.bottomRightCorner<5, 5>()));
  EXPECT_TRUE((after.topRightCorner<2, 5>().isZero(0.0)));
  EXPECT_TRUE((after.bottomLeftCorner<5, 2>().isZero(0.0)));
  EXPECT_DOUBLE_EQ(after(0, 0), 4e-4);
  EXPECT_EQ(after(0, 1), 0.0);
  EXPECT_EQ(filter.value()[kA], 0.9);
}

TEST(IntervalFilter, RefusesWhatIsNotFiniteAndStaysAsItWas) {
  IntervalFilter filter = filterWith(noiseOf(5e-6, 2e-6));
  filter.initialise(startValue(), startSigma(), kNoWalk);
  EXPECT_FALSE(filter.update().accepted);  // no sample at all
  const std::vector<RecordedStep> records = recordLoop(10, 0.0);
  filter.step(averagedStep(records[0].theta, records[0].phi, records[0].input),
              {std::nan(""), 0.0});
  EXPECT_FALSE(filter.update().accepted);
  filter.step(averagedStep(std::nan(""), records[0].phi, records[0].input), records[0].measured);
  EXPECT_FALSE(filter.update().accepted);
  EXPECT_EQ(filter.value(), startValue());
  EXPECT_TRUE(
      filter.covariance().isApprox(StateMatrix(startSigma().cwiseAbs2().asDiagonal()), 1e-15));
  take(filter, records[0]);
  EXPECT_TRUE(filter.update().accepted);
}

TEST(IntervalFilter, CovarianceStaysSymmetricAndPositiveOver300000Updates) {
  const std::vector<RecordedStep> records = recordLoop(30000, 5e-6);
  IntervalFilter filter = filterWith(noiseOf(5e-6, 0.0));
  StateVector sigma = startSigma();
  sigma[kA] = sigma[kB] = 1.0;  // a start as uncertain as possible
  filter.initialise(startValue(), sigma, kNoWalk);
  for (int n = 0; n < 300000; ++n) {
    const RecordedStep& record = records[static_cast<std::size_t>(n) % records.size()];
    // The record does not end where it begins: restart the axes when it repeats.
    if (n % 30000 == 0) filter.restartAxes(record.measured, 1.0);
    take(filter, record);
    ASSERT_TRUE(filter.update().accepted) << n;
    if (n % 100 != 0) continue;
    const StateMatrix covariance = filter.covariance();
    ASSERT_EQ(covariance, covariance.transpose()) << n;
    const StateVector scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
    const StateMatrix correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
    ASSERT_EQ(correlation.llt().info(), Eigen::Success) << n;
  }
  EXPECT_NEAR(filter.value()[kGamma1], kDevice.gamma1, 5e-6);
}

// Each has the expected value 2 and the variance 4. The limit is three sigmas of the mean of 6 runs
// with 300 updates each.
TEST(IntervalFilter, InnovationsAreAsLargeAsTheirCovarianceSays) {
  double sum = 0.0;
  int updates = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    IntervalFilter filter = filterWith(noiseOf(5e-6, 0.0));
    // Start near the truth: the test is about the noise, not about convergence.
    StateVector value, sigma;
    value << 1.0, 0.0, 0.0201, 0.0301, -30.01e-6, -40.01e-6, 1.1e5;
    sigma << 1e-3, 1e-3, 1e-3, 1e-3, 1e-8, 1e-8, 100.0;
    filter.initialise(value, sigma, kNoWalk);
    const std::vector<RecordedStep> records = recordLoop(30000, 5e-6, seed);
    for (std::size_t n = 0; n < records.size(); ++n) {
      take(filter, records[n]);
      if ((n + 1) % 100 != 0) continue;
      sum += filter.update().normalised_innovation_squared;
      ++updates;
    }
  }
  EXPECT_NEAR(sum / updates, 2.0, 3.0 * 2.0 / std::sqrt(updates));
}

TEST(IntervalFilter, RefusesNoiseOfNegativeVariance) {
  IntervalNoise noise = noiseOf(5e-6, 2e-6);
  noise.sample_variance = -1.0;
  for (const bool in_one : {false, true}) {
    IntervalFilter filter = filterWith(noise);
    filter.initialise(startValue(), startSigma(), kNoWalk);
    const StateVector value = filter.value();
    const StateMatrix covariance = filter.covariance();
    const RecordedStep record = recordLoop(1, 5e-6).front();
    if (in_one) {
      EXPECT_FALSE(takeAndUpdate(filter, record).accepted);
    } else {
      take(filter, record);
      EXPECT_FALSE(filter.update().accepted);
    }
    EXPECT_EQ(filter.value(), value);
    EXPECT_EQ(filter.covariance(), covariance);
  }
}

TEST(IntervalFilter, KnowsHowFarItIsLinear) {
  IntervalFilter filter = filterWith(noiseOf(5e-6, 2e-6));
  const double w = kTwoPi * kKnown.natural_frequency;
  StateVector sigma;
  sigma << 1e-3, 1e-3, 0.1, 0.1, 1e-4, 1e-4, 5e4;
  filter.initialise(startValue(), sigma, kNoWalk);
  EXPECT_FALSE(filter.isLinearOver(100, w));
  sigma << 1e-5, 1e-5, 1e-3, 1e-3, 1e-8, 1e-8, 100.0;
  filter.initialise(startValue(), sigma, kNoWalk);
  EXPECT_TRUE(filter.isLinearOver(100, w));
  EXPECT_FALSE(filter.isLinearOver(10000, w));
}

}  // namespace
}  // namespace cvg
