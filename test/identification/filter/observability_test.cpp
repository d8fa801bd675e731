// What each experiment can show: the posterior Cramer-Rao bound of every parameter, printed as the
// table of docs/observability.md.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "identification/averaged_loop.h"
#include "ring_gyro/identification/filter/extended_prior.h"
#include "ring_gyro/identification/judge/information_bound.h"

namespace cvg {
namespace {

constexpr double kNoise = 5e-6;  // [V/sqrt(Hz)]
constexpr double kDuration = 120.0;

/// What the operator does, by time [s].
struct Experiment {
  std::string name;
  std::function<double(double)> virtual_rate;  // [rad/s]
  std::function<double(double)> rotation;      // k Om, known [rad/s]
  bool modulated = false;                      // amplitude by 10 % at 0.3 Hz
};

double constantRate(double /*time*/) { return toRadians(12.0); }
double reversedRate(double time) {
  return std::fmod(time, 40.0) < 20.0 ? toRadians(12.0) : -toRadians(12.0);
}
double atRest(double /*time*/) { return 0.0; }

std::vector<Experiment> experiments() {
  return {{"steered", constantRate, atRest, false},
          {"steered, a mod.", constantRate, atRest, true},
          {"steered +-", reversedRate, atRest, false},
          {"+-, a mod.", reversedRate, atRest, true},
          {"turned", atRest, constantRate, false},
          {"turned +-", atRest, reversedRate, false},
          {"both +-, a mod.", [](double time) { return time < 60.0 ? reversedRate(time) : 0.0; },
           [](double time) { return time < 60.0 ? 0.0 : reversedRate(time); }, true}};
}

ExtendedParameters groups() {
  ExtendedParameters parameters;
  parameters.drive_matrix = parameters.drive_rotation = parameters.drift_bias = true;
  parameters.sense_matrix = parameters.rotation_scale = parameters.pickoff_cubic = true;
  parameters.even_harmonics = {1.0, 2.0, 4.0};
  return parameters;
}

struct Bound {
  ExtendedState state{AveragedLoop::Options().known, groups()};
  ExtendedVector prior;
  ExtendedMatrix covariance;

  Eigen::Index at(const std::string& name) const { return state.find(name).value(); }
  double sigma(const std::string& name) const { return std::sqrt(covariance(at(name), at(name))); }
  /// Share of the prior sigma that is left.
  double left(const std::string& name) const { return sigma(name) / prior[at(name)]; }
  double correlation(const std::string& one, const std::string& other) const {
    return covariance(at(one), at(other)) / (sigma(one) * sigma(other));
  }
};

/// A ring with a small mu: with a large mu the drive that nulls quadrature alone shows a lot.
Bound boundOf(const Experiment& experiment) {
  AveragedLoop::Options options;
  options.device.mu1 = 5e-7;
  options.device.mu2 = -4e-7;
  options.virtual_rate = experiment.virtual_rate(0.0);
  options.rotation_rate = experiment.rotation(0.0);
  AveragedLoop loop(options);
  Bound bound;
  ExtendedParameters parameters = groups();
  FirstLook look;
  look.drive_gain = options.device.drive_gain;
  look.frequency = options.known.natural_frequency;
  ExtendedVector truth = startValue(bound.state, parameters, look);
  truth.segment<5>(4) << options.device.gamma1, options.device.gamma2, options.device.mu1,
      options.device.mu2, options.device.drive_gain;
  bound.prior = priorSigma(bound.state, parameters, truth);
  bound.prior.head<4>().setOnes();
  EnvelopeBound recursion(EnvelopeModel(bound.state), truth, bound.prior, kNoise, 0.0,
                          ConverterParameters());
  for (int n = 0; n < std::lround(kDuration / options.block); ++n) {
    const double time = options.block * n;
    const double rotation = experiment.rotation(time);
    loop.setVirtualRate(experiment.virtual_rate(time));
    loop.setRotationRate(rotation);
    if (experiment.modulated) loop.setAmplitude(1.0 + 0.1 * std::sin(kTwoPi * 0.3 * time));
    const AveragedLoop::Output output = loop.step();
    recursion.process(output.elements, output.gains, rotation);
  }
  bound.covariance = recursion.covariance();
  return bound;
}

class Observability : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    bounds_ = new std::vector<Bound>;
    for (const Experiment& experiment : experiments()) bounds_->push_back(boundOf(experiment));
  }
  static void TearDownTestSuite() {
    delete bounds_;
    bounds_ = nullptr;
  }
  static const Bound& steered() { return (*bounds_)[0]; }
  static const Bound& steeredModulated() { return (*bounds_)[1]; }
  static const Bound& steeredReversed() { return (*bounds_)[2]; }
  static const Bound& steeredReversedModulated() { return (*bounds_)[3]; }
  static const Bound& turned() { return (*bounds_)[4]; }
  static const Bound& turnedReversed() { return (*bounds_)[5]; }
  static const Bound& both() { return (*bounds_)[6]; }

  static std::vector<Bound>* bounds_;
};

std::vector<Bound>* Observability::bounds_ = nullptr;

TEST_F(Observability, Table) {
  std::printf("Standard deviations after %.0f s; (prior) where more than half of it is left\n",
              kDuration);
  std::printf("%-21s", "");
  for (const Experiment& experiment : experiments()) std::printf(" %15s", experiment.name.c_str());
  std::printf("\n");
  const std::vector<std::string>& names = steered().state.names();
  for (std::size_t k = 4; k < names.size(); ++k) {
    std::printf("%-21s", names[k].c_str());
    for (const Bound& bound : *bounds_) {
      if (bound.left(names[k]) > 0.5) {
        std::printf(" %15s", "(prior)");
      } else {
        std::printf(" %15.1e", bound.sigma(names[k]));
      }
    }
    std::printf("\n");
  }
  std::printf("%-21s", "condition");
  for (const Bound& bound : *bounds_) {
    // Condition number of the correlation matrix of the parameters: large if some of them can
    // hardly be told apart.
    const Eigen::Index parameters = bound.state.size() - 4;
    const Eigen::MatrixXd covariance = bound.covariance.bottomRightCorner(parameters, parameters);
    const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
    const Eigen::MatrixXd correlation = covariance.cwiseQuotient(sigma * sigma.transpose());
    const Eigen::VectorXd values =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(correlation).eigenvalues();
    std::printf(" %15.1e", values[values.size() - 1] / values[0]);
    EXPECT_TRUE(covariance.allFinite());
  }
  std::printf("\n");
}

TEST_F(Observability, DriveMismatchIsDampingMismatchUntilTheRateIsReversedOrTheAmplitudeChanges) {
  // At constant amplitude and one rate only their difference acts, except for the small variation
  // of the sustain drive, which is of second order.
  for (const char* name : {"gamma1", "drive_mismatch"}) {
    EXPECT_GT(turned().sigma(name), 50.0 * steeredReversed().sigma(name)) << name;
    EXPECT_GT(steered().sigma(name), 20.0 * steeredModulated().sigma(name)) << name;
  }
  EXPECT_GT(steered().correlation("gamma1", "drive_mismatch"), 0.5);
}

TEST_F(Observability, PhaseMismatchIsStiffnessMismatchUntilTheRateIsReversedOrTheAmplitudeChanges) {
  for (const char* name : {"mu1", "phase_mismatch"}) {
    EXPECT_GT(steered().sigma(name), 10.0 * steeredModulated().sigma(name)) << name;
    EXPECT_GT(steered().sigma(name), 10.0 * steeredReversed().sigma(name)) << name;
  }
  // The required figure: 0.1 deg between the axes alone would look like a mu1 of 4e-8.
  EXPECT_LT(steeredReversed().sigma("mu1"), 5e-9);
}

TEST_F(Observability, TheSenseMatrixNeedsATrueRotationThatChanges) {
  for (const char* name : {"sense_mismatch", "sense_skew", "rotation_scale"}) {
    EXPECT_GT(steeredReversedModulated().left(name), 0.99) << name;
    EXPECT_LT(turnedReversed().left(name), 1e-2) << name;
    EXPECT_LT(both().left(name), 1e-2) << name;
  }
  EXPECT_GT(turned().left("sense_mismatch"), 0.05);
}

TEST_F(Observability, CubicPickOffAndEvenHarmonicsNeedOnlyATurningPattern) {
  for (const Bound& bound : *bounds_) {
    EXPECT_LT(bound.left("pickoff_cubic"), 1e-2);
    EXPECT_LT(bound.left("drift_cos1"), 1e-2);
    EXPECT_LT(bound.left("drift_cos4"), 1e-2);
  }
}

TEST_F(Observability, RotationOfTheDriveIsABiasUntilTheSteeringIsReversed) {
  EXPECT_LT(steeredReversed().sigma("drift_bias"), 0.2 * turned().sigma("drift_bias"));
  EXPECT_GT(std::abs(turned().correlation("drift_bias", "drive_rotation")), 0.95);
}

TEST_F(Observability, QualityNeedsSteeringOrAChangeOfTheAmplitude) {
  EXPECT_LT(steeredReversedModulated().sigma("decay_rate"), steeredReversed().sigma("decay_rate"));
  EXPECT_LT(steeredReversed().sigma("decay_rate"), 0.2 * turned().sigma("decay_rate"));
}

}  // namespace
}  // namespace cvg
