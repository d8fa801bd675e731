// The posterior Cramer-Rao bound against closed forms, and the filters against the bound.

#include "ring_gyro/identification/judge/information_bound.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "identification/averaged_loop.h"
#include "ring_gyro/identification/filter/extended_identifier.h"
#include "ring_gyro/identification/filter/identifier.h"

namespace cvg {
namespace {

constexpr double kNoise = 5e-6;  // [V/sqrt(Hz)]
constexpr double kDuration = 60.0;

TEST(InformationBound, OfARandomWalkIsTheRiccatiEquation) {
  ExtendedMatrix prior(2, 2);
  prior << 4.0, 0.0, 0.0, 9.0;
  InformationBound bound(prior, 1);
  InformationBound::Rows transition(1, 2);
  transition << 1.0, 0.0;
  const double process = 0.01;
  const double noise = 1.0;
  for (int n = 0; n < 1000; ++n) {
    bound.step(transition, process);
    bound.measure(transition, noise);
  }
  // P = (P + q) r / (P + q + r) at rest.
  const double expected = 0.5 * (-process + std::sqrt(process * process + 4.0 * process * noise));
  EXPECT_NEAR(bound.covariance()(0, 0), expected, 1e-9);
  EXPECT_NEAR(bound.covariance()(1, 1), 9.0, 1e-12);
}

TEST(InformationBound, OfALineIsThatOfLeastSquares) {
  ExtendedMatrix prior(2, 2);
  prior << 1e6, 0.0, 0.0, 1e6;
  InformationBound bound(prior, 1);
  InformationBound::Rows transition(1, 2);
  transition << 1.0, 0.1;  // position, and rate times 0.1 s
  InformationBound::Rows measurement(1, 2);
  measurement << 1.0, 0.0;
  const int samples = 100;
  for (int n = 0; n < samples; ++n) {
    bound.step(transition, 0.0);
    bound.measure(measurement, 0.25);
  }
  // Variance of a slope from equidistant points.
  const double expected = 12.0 * 0.25 / (0.1 * 0.1 * samples * (1.0 * samples * samples - 1.0));
  EXPECT_NEAR(bound.covariance()(1, 1) / expected, 1.0, 1e-6);
}

AveragedLoop::Options smallMu() {
  AveragedLoop::Options options;
  options.device.mu1 = 5e-7;
  options.device.mu2 = -4e-7;
  options.bandwidth = 10.0;
  return options;
}

ExtendedParameters extendedParameters() {
  ExtendedParameters parameters;
  parameters.noise_density = kNoise;
  parameters.envelope_process_noise = 0.0;
  return parameters;
}

StateMatrix axesBound(AveragedLoop::Options options) {
  const ConverterParameters converter;
  StateVector prior;
  prior << 1.0, 1.0, 0.1, 0.1, 1e-4, 1e-4, 0.5 * options.device.drive_gain;
  AxesBound bound(AveragedModel(options.known), options.device, prior, kNoise, 0.0, converter);
  AveragedLoop loop(options);
  for (int n = 0; n < std::lround(kDuration / options.block); ++n) {
    const AveragedLoop::Output output = loop.step();
    bound.process(output.elements, output.gains);
  }
  return bound.covariance();
}

TEST(AxesBound, IsWhatASwingThroughTheDecayShows) {
  const AveragedLoop::Options options = smallMu();
  const StateMatrix bound = axesBound(options);
  // A variation with 2 theta, of relative size gamma, acts on a through the decay. Measured for a
  // time T with noise of density N^2, its amplitude has the variance 2 N^2 / T, a constant N^2 / T.
  const double decay = options.known.decayRate();
  const double swing = std::hypot(decay, 2.0 * options.virtual_rate);
  const double amplitude = kNoise * std::sqrt(2.0 / kDuration);
  const auto sigma = [&bound](StateIndex k) { return std::sqrt(bound(k, k)); };
  std::printf("a and b alone, %.0f s: gamma %.2e %.2e, mu %.2e %.2e, ks %.2e relative\n", kDuration,
              sigma(kGamma1), sigma(kGamma2), sigma(kMu1), sigma(kMu2),
              sigma(kDriveGain) / options.device.drive_gain);
  const double gamma = amplitude * swing / decay;
  const double mu = amplitude * swing / (kPi * options.known.natural_frequency);
  EXPECT_NEAR(sigma(kGamma1) / gamma, 1.0, 0.06);
  EXPECT_NEAR(sigma(kGamma2) / gamma, 1.0, 0.06);
  EXPECT_NEAR(sigma(kMu1) / mu, 1.0, 0.06);
  EXPECT_NEAR(sigma(kMu2) / mu, 1.0, 0.06);
  EXPECT_NEAR(sigma(kDriveGain) / options.device.drive_gain / (kNoise / std::sqrt(kDuration)), 1.0,
              0.06);
}

TEST(AxesBound, IsReachedByTheIdentifier) {
  AveragedLoop::Options options = smallMu();
  const StateMatrix bound = axesBound(options);
  options.noise_density = kNoise;
  IdentificationParameters parameters;
  parameters.noise_density = kNoise;
  parameters.axis_process_noise = 0.0;
  Identifier identifier(options.known, parameters, ConverterParameters());
  AveragedLoop loop(options);
  ParameterEstimate last;
  for (int n = 0; n < std::lround(kDuration / options.block); ++n) {
    const AveragedLoop::Output output = loop.step();
    if (const auto estimate = identifier.process(output.elements, output.gains)) last = *estimate;
  }
  for (StateIndex k : {kGamma1, kGamma2, kMu1, kMu2, kDriveGain}) {
    EXPECT_NEAR(last.sigma(k) / std::sqrt(bound(k, k)), 1.0, 0.05) << k;
  }
}

TEST(EnvelopeBound, IsReachedByTheExtendedIdentifierAndBelowThatOfTheAxes) {
  AveragedLoop::Options options = smallMu();
  const StateMatrix axes = axesBound(options);
  const ExtendedParameters parameters = extendedParameters();
  const ConverterParameters converter;
  const EnvelopeModel model{ExtendedState(options.known, parameters)};
  const ExtendedState& state = model.state();
  const ExtendedState::Layout& at = state.layout();
  ExtendedVector truth = ExtendedVector::Zero(state.size());
  truth.segment<2>(at.gamma) << options.device.gamma1, options.device.gamma2;
  truth.segment<2>(at.mu) << options.device.mu1, options.device.mu2;
  truth[at.drive_gain] = options.device.drive_gain;
  truth[at.decay_rate] = options.known.decayRate();
  truth[at.frequency] = options.known.natural_frequency;
  ExtendedVector prior = ExtendedVector::Ones(state.size());
  prior.segment<2>(at.gamma).setConstant(0.1);
  prior.segment<2>(at.mu).setConstant(1e-4);
  prior[at.drive_gain] = 0.5 * truth[at.drive_gain];
  prior[at.decay_rate] = 0.5 * truth[at.decay_rate];
  EnvelopeBound bound(model, truth, prior, kNoise, 0.0, converter);

  AveragedLoop quiet(options);
  options.noise_density = kNoise;
  AveragedLoop loop(options);
  ExtendedIdentifier identifier(options.known, parameters, converter);
  ExtendedEstimate last;
  for (int n = 0; n < std::lround(kDuration / options.block); ++n) {
    const AveragedLoop::Output without = quiet.step();
    bound.process(without.elements, without.gains);
    const AveragedLoop::Output output = loop.step();
    if (const auto estimate = identifier.process(output.elements, output.gains)) last = *estimate;
  }
  const ExtendedMatrix covariance = bound.covariance();
  for (Eigen::Index k = 4; k < state.size(); ++k) {
    EXPECT_NEAR(last.sigma(k) / std::sqrt(covariance(k, k)), 1.0, 0.03)
        << state.names()[static_cast<std::size_t>(k)];
  }
  // Angle and phase show gamma and mu as well.
  for (int k = 0; k < 4; ++k) EXPECT_LT(covariance(4 + k, 4 + k), 0.6 * axes(2 + k, 2 + k));
}

TEST(EnvelopeBound, DoesNotChangeWithTheLoopsNoise) {
  // The derivatives are taken at the truth; noise in the drive has only a second-order effect.
  const AveragedLoop::Options options = smallMu();
  AveragedLoop::Options noisy = options;
  noisy.noise_density = kNoise;
  const ConverterParameters converter;
  StateVector prior;
  prior << 1.0, 1.0, 0.1, 0.1, 1e-4, 1e-4, 0.5 * options.device.drive_gain;
  AxesBound one(AveragedModel(options.known), options.device, prior, kNoise, 0.0, converter);
  AxesBound other = one;
  AveragedLoop quiet(options);
  AveragedLoop loud(noisy);
  for (int n = 0; n < 20000; ++n) {
    const AveragedLoop::Output without = quiet.step();
    one.process(without.elements, without.gains);
    const AveragedLoop::Output with = loud.step();
    other.process(with.elements, with.gains);
  }
  for (int k = 2; k < 7; ++k) {
    EXPECT_NEAR(one.covariance()(k, k) / other.covariance()(k, k), 1.0, 0.01);
  }
}

}  // namespace
}  // namespace cvg
