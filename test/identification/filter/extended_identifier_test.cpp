// The extended identifier: its model against numeric derivatives, and each group of parameters
// identified from the time-domain plant with the real loops.

#include "ring_gyro/identification/filter/extended_identifier.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/control/control_loops.h"
#include "ring_gyro/resonator/plant_simulator.h"
#include "ring_gyro/signals/calibration_command.h"

namespace cvg {
namespace {

using Complex = std::complex<double>;

constexpr double kFrequency = 14e3;  // [Hz]
constexpr double kNoise = 5e-6;      // [V/sqrt(Hz)]
const DeviceKnowledge kKnown = {kFrequency, 22000.0};

ExtendedParameters everything() {
  ExtendedParameters parameters;
  parameters.drive_matrix = parameters.drive_rotation = parameters.drift_bias = true;
  parameters.sense_matrix = parameters.rotation_scale = parameters.pickoff_cubic = true;
  parameters.even_harmonics = {1.0, 4.0};
  parameters.odd_harmonics = {1.0, 2.0};
  return parameters;
}

/// A device with every error, physical coordinates.
ExtendedVector someState(const ExtendedState& state) {
  ExtendedVector value(state.size());
  for (Eigen::Index k = 0; k < value.size(); ++k) value[k] = 1e-3 * std::sin(1.7 * double(k) + 1.0);
  value.head<4>() << 0.03, -0.8, 0.02, -0.6;
  const ExtendedState::Layout& at = state.layout();
  value.segment<2>(at.gamma) << 0.02, -0.03;
  value.segment<2>(at.mu) << 3e-5, -4e-5;
  value[at.drive_gain] = 1.1e5;
  if (at.decay_rate >= 0) value[at.decay_rate] = 2.1;
  if (at.frequency >= 0) value[at.frequency] = kFrequency + 0.3;
  if (at.pickoff_cubic >= 0) value[at.pickoff_cubic] = 0.02;
  if (at.rotation_rate >= 0) value[at.rotation_rate] = 0.3;
  return value;
}

EnvelopeInput someInput() {
  EnvelopeInput input;
  input.drive = {Complex(0.3, -0.05), Complex(0.2, 0.1)};
  input.reference_frequency = kTwoPi * (kFrequency + 0.2);
  input.theta = 0.7;
  input.rotation_rate = 0.25;
  return input;
}

void expectClose(const ExtendedMatrix& found, const ExtendedMatrix& expected, double relative,
                 const std::vector<std::string>& columns) {
  for (Eigen::Index column = 0; column < expected.cols(); ++column) {
    const double size = expected.col(column).norm();
    EXPECT_LE((found - expected).col(column).norm(), relative * size + 1e-12)
        << columns[static_cast<std::size_t>(column)];
  }
}

TEST(ExtendedState, PhysicalAndLinearCoordinatesAreInverse) {
  const ExtendedState state(kKnown, everything());
  const ExtendedVector physical = someState(state);
  const ExtendedVector linear = state.linear(physical);
  EXPECT_LT((state.physical(linear) - physical).cwiseAbs().maxCoeff(), 1e-9);
  const ExtendedMatrix product = state.physicalByLinear(linear) * state.linearByPhysical(physical);
  EXPECT_LT((product - ExtendedMatrix::Identity(state.size(), state.size())).cwiseAbs().maxCoeff(),
            1e-9);
}

TEST(ExtendedState, LinearByPhysicalIsTheDerivative) {
  const ExtendedState state(kKnown, everything());
  const ExtendedVector physical = someState(state);
  ExtendedMatrix numeric(state.size(), state.size());
  for (Eigen::Index k = 0; k < state.size(); ++k) {
    const double step = 1e-4 * std::abs(physical[k]);
    ExtendedVector more = physical;
    ExtendedVector less = physical;
    more[k] += step;
    less[k] -= step;
    numeric.col(k) = (state.linear(more) - state.linear(less)) / (2.0 * step);
  }
  expectClose(state.linearByPhysical(physical), numeric, 1e-7, state.names());
}

TEST(ExtendedState, RefusesWhatCannotBeToldApart) {
  ExtendedParameters parameters = everything();
  parameters.estimate_rotation = true;
  EXPECT_THROW(ExtendedState(kKnown, parameters), std::invalid_argument);
  parameters = everything();
  parameters.even_harmonics = {1.5};
  EXPECT_THROW(ExtendedState(kKnown, parameters), std::invalid_argument);
  parameters.even_harmonics = {2.0, 2.0};
  EXPECT_THROW(ExtendedState(kKnown, parameters), std::invalid_argument);
  EXPECT_THROW(ExtendedState({kFrequency, 0.0}, everything()), std::invalid_argument);
}

void expectStepDerivatives(const ExtendedParameters& parameters) {
  const EnvelopeModel model{ExtendedState(kKnown, parameters)};
  const ExtendedState& state = model.state();
  const ExtendedVector value = state.linear(someState(state));
  const EnvelopeInput input = someInput();
  const auto after = [&](const ExtendedVector& at) {
    const Eigen::Vector4d envelope = at.head<4>();
    EnvelopeStep step;
    model.step(envelope, at, {envelope, at}, input, 1e-3, step);
    return step.after;
  };
  EnvelopeSensitivity numeric(4, state.size());
  EnvelopeSensitivity shown(4, state.size());
  for (Eigen::Index k = 0; k < state.size(); ++k) {
    // Too small to change the derivative, but large compared with rounding.
    const double step =
        k == state.layout().frequency ? 1e-3 : 1e-3 * std::max(std::abs(value[k]), 1e-6);
    ExtendedVector more = value;
    ExtendedVector less = value;
    more[k] += step;
    less[k] -= step;
    numeric.col(k) = (after(more) - after(less)) / (2.0 * step);
    shown.col(k) =
        (model.measure(more.head<4>(), more).value - model.measure(less.head<4>(), less).value) /
        (2.0 * step);
  }
  const Eigen::Vector4d envelope = value.head<4>();
  EnvelopeStep step;
  model.step(envelope, value, {envelope, value}, input, 1e-3, step);
  EnvelopeSensitivity analytic(4, state.size());
  analytic << step.transition, step.by_parameters;
  expectClose(analytic, numeric, 1e-4, state.names());

  const EnvelopeModel::Measurement measured = model.measure(envelope, value);
  EXPECT_LT((measured.by_envelope - shown.leftCols<4>()).norm(), 1e-6);
  if (state.layout().pickoff_cubic >= 0) {
    EXPECT_LT((measured.by_cubic - shown.col(state.layout().pickoff_cubic)).norm(), 1e-6);
  }
  EXPECT_LT((model.undistorted(measured.value, value) - envelope).norm(), 1e-12);
}

TEST(EnvelopeModel, DerivativesAgreeWithNumericOnes) {
  expectStepDerivatives(everything());
  ExtendedParameters rotation = everything();
  rotation.drift_bias = rotation.rotation_scale = false;
  rotation.estimate_rotation = true;
  expectStepDerivatives(rotation);
  ExtendedParameters least;
  least.quality = least.frequency = false;
  expectStepDerivatives(least);
}

TEST(EnvelopeModel, LinearisedStepIsExactToFirstOrder) {
  const EnvelopeModel model{ExtendedState(kKnown, everything())};
  const ExtendedVector nominal = model.state().linear(someState(model.state()));
  ExtendedVector value = nominal;
  for (Eigen::Index k = 4; k < value.size(); ++k) value[k] *= 1.0 + 1e-9;
  const Eigen::Vector4d envelope = nominal.head<4>();
  EnvelopeStep unchanged;
  EnvelopeStep there;
  EnvelopeStep linearised;
  model.step(envelope, nominal, {envelope, nominal}, someInput(), 1e-3, unchanged);
  model.step(envelope, value, {envelope, value}, someInput(), 1e-3, there);
  model.step(envelope, value, {envelope, nominal}, someInput(), 1e-3, linearised);
  const double change = (there.after - unchanged.after).norm();
  EXPECT_GT(change, 1e-8);
  EXPECT_LT((there.after - linearised.after).norm(), 1e-4 * change);
}

/// A device, its electronics and an experiment on it.
struct Experiment {
  PlantParameters plant;
  DeviceKnowledge told_to_loops = {kFrequency, 20000.0, 1.0e5};
  DeviceKnowledge told_to_identifier = {kFrequency + 2.0, 20000.0};
  ControlParameters control;
  ExtendedParameters extended;
  double duration = 60.0;
  std::function<double(double)> virtual_rate;  // of the time; empty: that of `control`

  Experiment() {
    ResonatorParameters& ring = plant.resonator;
    ring.natural_frequency = kFrequency;
    ring.quality_factor = 22000.0;
    ring.gamma1 = 0.02;
    ring.gamma2 = 0.03;
    ring.mu1 = -30e-6;
    ring.mu2 = -40e-6;
    ring.drive_gain = 1.1e5;
    plant.sense.noise_density = kNoise;
    control.virtual_rate = toRadians(12.0);
    extended.noise_density = kNoise;
    extended.envelope_process_noise = 0.0;
  }

  void reverse(double period) {
    virtual_rate = [period](double time) {
      return std::fmod(time, 2.0 * period) < period ? toRadians(12.0) : -toRadians(12.0);
    };
  }
};

struct Outcome {
  ExtendedEstimate last;
  std::vector<std::string> names;
  double mean_nis = 0.0;
  int updates = 0;

  Eigen::Index at(const std::string& name) const {
    const auto found = std::find(names.begin(), names.end(), name);
    EXPECT_NE(found, names.end()) << name;
    return found - names.begin();
  }
  double value(const std::string& name) const { return last.value[at(name)]; }
  double sigma(const std::string& name) const { return last.sigma(at(name)); }
};

Outcome run(const Experiment& experiment) {
  const ConverterParameters converter;
  PlantSimulator plant(experiment.plant, converter, 1, 1, 1000000000);
  ControlLoops loops(experiment.told_to_loops, experiment.control, {}, converter);
  ExtendedIdentifier identifier(experiment.told_to_identifier, experiment.extended, converter);
  Outcome outcome;
  outcome.names = identifier.names();
  const DisplacementBlock* block = &plant.start();
  const auto blocks = std::llround(experiment.duration / converter.blockDuration());
  for (long long n = 0; n < blocks; ++n) {
    if (experiment.virtual_rate) {
      LoopSettings settings;
      settings.virtual_rate = experiment.virtual_rate(1e-3 * static_cast<double>(n));
      loops.setSettings(settings);
    }
    const LoopOutput& output = loops.process(*block);
    const auto estimate =
        identifier.process(output.elements, output.gains, plant.truth().rotation_rate);
    if (estimate) {
      outcome.last = *estimate;
      if (estimate->settled && estimate->whole_period && estimate->updated) {
        outcome.mean_nis += estimate->normalised_innovation_squared;
        ++outcome.updates;
      }
    }
    block = &plant.step(output.command);
  }
  outcome.mean_nis /= outcome.updates;
  return outcome;
}

/// Expects the estimate within 4 sigmas of the truth, and a sigma below `largest_sigma`.
void expectFound(const Outcome& outcome, const std::string& name, double truth,
                 double largest_sigma) {
  EXPECT_NEAR(outcome.value(name), truth, 4.0 * outcome.sigma(name)) << name;
  EXPECT_LT(outcome.sigma(name), largest_sigma) << name;
}

void expectWhite(const Outcome& outcome) {
  // Chi squared with 4 degrees of freedom per update; four standard deviations of the mean.
  EXPECT_NEAR(outcome.mean_nis, 4.0, 4.0 * std::sqrt(8.0 / outcome.updates));
}

void expectRing(const Outcome& outcome, double gamma, double mu) {
  expectFound(outcome, "gamma1", 0.02, gamma);
  expectFound(outcome, "gamma2", 0.03, gamma);
  expectFound(outcome, "mu1", -30e-6, mu);
  expectFound(outcome, "mu2", -40e-6, mu);
}

TEST(ExtendedIdentifier, FindsTheRingWithQualityAndFrequencyUnknown) {
  const Outcome outcome = run(Experiment());
  expectRing(outcome, 2e-6, 1e-10);
  expectFound(outcome, "drive_gain", 1.1e5, 0.5);
  expectFound(outcome, "decay_rate", kPi * kFrequency / 22000.0, 1e-5);
  expectFound(outcome, "natural_frequency", kFrequency, 1e-6);
  EXPECT_NEAR(outcome.last.quality_factor, 22000.0, 0.2);
  expectWhite(outcome);
}

TEST(ExtendedIdentifier, IsNotBiasedWithoutNoise) {
  Experiment experiment;
  experiment.plant.sense.noise_density = 0.0;
  const Outcome outcome = run(experiment);
  EXPECT_NEAR(outcome.value("gamma1"), 0.02, 1e-8);
  EXPECT_NEAR(outcome.value("gamma2"), 0.03, 1e-8);
  EXPECT_NEAR(outcome.value("mu1"), -30e-6, 1e-11);
  EXPECT_NEAR(outcome.value("mu2"), -40e-6, 1e-11);
  EXPECT_NEAR(outcome.value("drive_gain") / 1.1e5, 1.0, 3e-8);
}

TEST(ExtendedIdentifier, RecoversFromAGuessOfKsTenTimesOffAndGammaOfTheWrongSign) {
  Experiment experiment;
  experiment.extended.initial_drive_gain = 1.1e6;
  experiment.extended.initial_drive_gain_sigma = 1.0;
  experiment.extended.initial_gamma1 = -0.02;
  experiment.extended.initial_gamma2 = -0.03;
  const Outcome outcome = run(experiment);
  expectRing(outcome, 2e-6, 1e-10);
  expectFound(outcome, "drive_gain", 1.1e5, 0.5);
  expectWhite(outcome);
}

Experiment withDriveErrors() {
  Experiment experiment;
  AxisErrors& axes = experiment.plant.drive.axes;
  axes.gain_x = 1.004;
  axes.gain_y = 0.996;
  axes.misalignment = 0.005;
  axes.phase_delay = 0.0087;
  axes.phase_difference = 0.00174;
  experiment.extended.drive_matrix = experiment.extended.drive_rotation = true;
  experiment.extended.drift_bias = true;
  return experiment;
}

TEST(ExtendedIdentifier, FindsTheDriveMatrixWhenTheVirtualRateIsReversed) {
  Experiment experiment = withDriveErrors();
  experiment.reverse(30.0);
  experiment.duration = 120.0;
  const Outcome outcome = run(experiment);
  expectRing(outcome, 3e-6, 1e-10);
  const AxisErrors& axes = experiment.plant.drive.axes;
  Eigen::Matrix2cd matrix = axes.gainMatrix().cast<Complex>();
  for (int k = 0; k < 2; ++k) matrix.col(k) *= std::polar(1.0, -axes.phaseDelays()[k]);
  const Complex common = 0.5 * (matrix(0, 0) + matrix(1, 1));
  const Complex along = 0.5 * (matrix(0, 0) - matrix(1, 1)) / common;
  const Complex across = 0.5 * (matrix(0, 1) + matrix(1, 0)) / common;
  const Complex turn = 0.5 * (matrix(0, 1) - matrix(1, 0)) / common;
  expectFound(outcome, "drive_gain", 1.1e5 * std::abs(common), 0.5);
  expectFound(outcome, "drive_phase", -std::arg(common), 3e-6);
  expectFound(outcome, "drive_mismatch", along.real(), 3e-6);
  expectFound(outcome, "phase_mismatch", along.imag(), 3e-6);
  expectFound(outcome, "drive_skew", across.real(), 3e-6);
  expectFound(outcome, "phase_skew", across.imag(), 3e-6);
  expectFound(outcome, "drive_rotation", turn.real(), 3e-6);
  expectFound(outcome, "drive_rotation_phase", turn.imag(), 3e-6);
  expectFound(outcome, "drift_bias", 0.0, 1e-5);
  expectWhite(outcome);
}

// With a larger mu, the drive that cancels quadrature alone would tell the errors apart.
Experiment withDriveErrorsAndSmallMu() {
  Experiment experiment = withDriveErrors();
  experiment.plant.resonator.mu1 = 5e-7;
  experiment.plant.resonator.mu2 = -4e-7;
  return experiment;
}

// With steering in one direction only, a rotation of the drive and a drift that is the same at
// every angle differ only by the effect of the slow variation of the sustain drive, which is small.
TEST(ExtendedIdentifier, RotationAndBiasSeparateByReversingTheRate) {
  Experiment one_way = withDriveErrorsAndSmallMu();
  Experiment reversed = withDriveErrorsAndSmallMu();
  reversed.reverse(15.0);
  const Outcome less = run(one_way);
  const Outcome more = run(reversed);
  EXPECT_GT(less.sigma("drive_rotation"), 5.0 * more.sigma("drive_rotation"));
  EXPECT_GT(less.sigma("drift_bias"), 5.0 * more.sigma("drift_bias"));
  EXPECT_NEAR(less.value("drift_bias"), 0.0, 4.0 * less.sigma("drift_bias"));
}

// Without steering and at constant amplitude, damping mismatch and drive mismatch have the same
// effect: the sigmas must show that the data do not separate them.
TEST(ExtendedIdentifier, KeepsThePriorOfWhatCannotBeToldApart) {
  Experiment experiment = withDriveErrorsAndSmallMu();
  experiment.control.virtual_rate = 0.0;
  experiment.plant.rotation.rate = toRadians(12.0);
  const Outcome outcome = run(experiment);
  for (const char* name : {"gamma1", "gamma2", "drive_mismatch", "drive_skew"}) {
    EXPECT_GT(outcome.sigma(name), 3e-5) << name;
  }
  EXPECT_NEAR(outcome.value("gamma1"), 0.02, 4.0 * outcome.sigma("gamma1"));
  // Their difference turns the pattern, so it is known.
  const Eigen::Index gamma = outcome.at("gamma1");
  const Eigen::Index drive = outcome.at("drive_mismatch");
  const ExtendedMatrix& covariance = outcome.last.covariance;
  const double difference =
      covariance(gamma, gamma) + covariance(drive, drive) - 2.0 * covariance(gamma, drive);
  EXPECT_LT(std::sqrt(difference), 0.1 * outcome.sigma("gamma1"));
}

TEST(ExtendedIdentifier, FindsTheSenseMatrixUnderReversedRotation) {
  Experiment experiment;
  AxisErrors& axes = experiment.plant.sense.axes;
  axes.gain_x = 1.005;
  axes.gain_y = 0.995;
  experiment.plant.resonator.mu1 = 5e-7;
  experiment.plant.resonator.mu2 = -4e-7;
  experiment.control.virtual_rate = 0.0;
  experiment.plant.rotation.profile = RotationShape::kSine;
  experiment.plant.rotation.amplitude = 1.0;
  experiment.plant.rotation.frequency = 0.05;
  ExtendedParameters& extended = experiment.extended;
  extended.drive_matrix = extended.drive_rotation = extended.drift_bias = true;
  extended.sense_matrix = extended.rotation_scale = true;
  experiment.duration = 20.0;
  const Outcome outcome = run(experiment);
  expectFound(outcome, "sense_mismatch", 0.005, 1e-5);
  expectFound(outcome, "sense_skew", 0.0, 1e-5);
}

TEST(ExtendedIdentifier, FindsTheCubicPickOff) {
  for (double cubic : {0.0, 0.02}) {
    Experiment experiment;
    experiment.plant.sense.cubic = cubic;
    experiment.extended.pickoff_cubic = true;
    const Outcome outcome = run(experiment);
    EXPECT_TRUE(outcome.last.settled);
    expectRing(outcome, 2e-6, 1e-10);
    expectFound(outcome, "pickoff_cubic", cubic, 1e-5);
    expectWhite(outcome);
  }
}

TEST(ExtendedIdentifier, FindsEvenHarmonicsAndCubicTogether) {
  Experiment experiment = withDriveErrors();
  experiment.reverse(20.0);
  experiment.duration = 120.0;
  experiment.plant.sense.cubic = 0.02;
  experiment.extended.pickoff_cubic = true;
  experiment.extended.even_harmonics = {1.0, 2.0, 3.0, 4.0};
  const Outcome outcome = run(experiment);
  EXPECT_TRUE(outcome.last.settled);
  expectRing(outcome, 2e-5, 1e-9);
  expectFound(outcome, "pickoff_cubic", 0.02, 5e-5);
  for (const char* name : {"drift_cos1", "drift_sin1", "drift_cos4", "drift_sin4"}) {
    expectFound(outcome, name, 0.0, 2e-5);
  }
  expectWhite(outcome);
}

TEST(ExtendedIdentifier, FindsTheRotationOfTheCase) {
  Experiment experiment;
  experiment.plant.rotation.rate = 0.05;
  experiment.extended.estimate_rotation = true;
  const Outcome outcome = run(experiment);
  expectRing(outcome, 2e-6, 1e-10);
  expectFound(outcome, "rotation_rate", 0.05, 1e-5);
  expectWhite(outcome);
}

TEST(ExtendedIdentifier, KeepsItsParametersOverAGapAndForgetsThemWithASession) {
  const ConverterParameters converter;
  const Experiment experiment;
  PlantSimulator plant(experiment.plant, converter, 1, 1, 1000000000);
  ControlLoops loops(experiment.told_to_loops, experiment.control, {}, converter);
  ExtendedIdentifier identifier(experiment.told_to_identifier, experiment.extended, converter);
  const DisplacementBlock* block = &plant.start();
  ExtendedEstimate before;
  ExtendedEstimate after;
  LoopOutput output;
  for (int n = 0; n < 20000; ++n) {
    output = loops.process(*block);
    // Lost blocks, an unusable one, and one with a NaN.
    const bool lost = n >= 15020 && n < 15150;
    if (n == 16010) output.elements.status.converter_saturated = true;
    if (n == 17050) output.gains.drive.sustain.x() = std::numeric_limits<double>::quiet_NaN();
    if (!lost) {
      if (const auto estimate = identifier.process(output.elements, output.gains)) {
        (n < 15000 ? before : after) = *estimate;
        EXPECT_TRUE(estimate->value.allFinite());
        EXPECT_TRUE(estimate->covariance.allFinite());
      }
    }
    block = &plant.step(output.command);
  }
  EXPECT_EQ(after.lost_blocks, 130u);
  EXPECT_EQ(after.used_blocks + after.rejected_blocks + after.lost_blocks, 20000u);
  EXPECT_LT(after.sigma(4), before.sigma(4));
  EXPECT_NEAR(after.value[4], 0.02, 4.0 * after.sigma(4));

  output.elements.stamp.session = output.gains.stamp.session = 2;
  output.elements.stamp.sequence = output.gains.stamp.sequence = 99;
  const auto fresh = identifier.process(output.elements, output.gains);
  ASSERT_TRUE(fresh);
  EXPECT_FALSE(fresh->scaled);
  EXPECT_FALSE(fresh->updated);
}

TEST(ExtendedIdentifier, RefusesWhatItCannotUse) {
  ExtendedParameters parameters = Experiment().extended;
  parameters.update_period = 0.0003;
  EXPECT_THROW(ExtendedIdentifier(kKnown, parameters, ConverterParameters()),
               std::invalid_argument);
  parameters = Experiment().extended;
  parameters.initial_gamma_sigma = 0.0;
  EXPECT_THROW(ExtendedIdentifier(kKnown, parameters, ConverterParameters()),
               std::invalid_argument);
}

}  // namespace
}  // namespace cvg
