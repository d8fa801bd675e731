// The batch fit: without noise it is exact from any guess; with noise the filter comes near it.

#include "ring_gyro/identification/judge/batch_least_squares.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "identification/averaged_loop.h"
#include "ring_gyro/identification/filter/extended_identifier.h"

namespace cvg {
namespace {

constexpr double kNoise = 5e-6;  // [V/sqrt(Hz)]

/// Knowledge of the device with a wrong Q.
DeviceKnowledge toldOf(const AveragedLoop::Options& options) {
  DeviceKnowledge told = options.known;
  told.quality_factor *= 0.8;
  return told;
}

ExtendedParameters noisy() {
  ExtendedParameters result;
  result.noise_density = kNoise;
  result.envelope_process_noise = 0.0;
  return result;
}

TEST(BatchLeastSquares, FindsTheDeviceFromAWrongGuess) {
  const AveragedLoop::Options options;
  ExtendedParameters parameters = noisy();
  parameters.initial_drive_gain = 10.0 * options.device.drive_gain;
  parameters.initial_drive_gain_sigma = 1.0;
  parameters.initial_gamma1 = -options.device.gamma1;
  parameters.initial_gamma2 = -options.device.gamma2;
  BatchLeastSquares fit(toldOf(options), parameters, ConverterParameters());
  AveragedLoop loop(options);
  for (int n = 0; n < 20000; ++n) {
    const AveragedLoop::Output output = loop.step();
    fit.add(output.elements, output.gains);
  }
  const BatchEstimate estimate = fit.solve();
  EXPECT_TRUE(estimate.converged);
  EXPECT_LE(estimate.passes, 8);
  EXPECT_NEAR(estimate.value[4], options.device.gamma1, 1e-6);
  EXPECT_NEAR(estimate.value[5], options.device.gamma2, 1e-6);
  EXPECT_NEAR(estimate.value[6], options.device.mu1, 1e-9);
  EXPECT_NEAR(estimate.value[7], options.device.mu2, 1e-9);
  EXPECT_NEAR(estimate.value[8] / options.device.drive_gain, 1.0, 1e-6);
}

// Without a group delay the first block after lost ones can be used, but no step leads to it.
TEST(BatchLeastSquares, LostBlocksEndAPiece) {
  const AveragedLoop::Options options;
  BatchLeastSquares fit(options.known, noisy(), ConverterParameters());
  AveragedLoop loop(options);
  for (int n = 0; n < 20000; ++n) {
    const AveragedLoop::Output output = loop.step();
    if (n % 5000 > 100) fit.add(output.elements, output.gains);
  }
  const BatchEstimate estimate = fit.solve();
  EXPECT_TRUE(estimate.converged);
  EXPECT_NEAR(estimate.value[4], options.device.gamma1, 1e-6);
  EXPECT_NEAR(estimate.value[5], options.device.gamma2, 1e-6);
  EXPECT_NEAR(estimate.value[8] / options.device.drive_gain, 1.0, 1e-6);
}

TEST(BatchLeastSquares, AgreesWithTheFilterOverGapsAndExplainsTheNoise) {
  AveragedLoop::Options options;
  options.noise_density = kNoise;
  const ExtendedParameters parameters = noisy();
  BatchLeastSquares fit(toldOf(options), parameters, ConverterParameters());
  ExtendedIdentifier identifier(toldOf(options), parameters, ConverterParameters());
  AveragedLoop loop(options);
  ExtendedEstimate last;
  for (int n = 0; n < 60000; ++n) {
    AveragedLoop::Output output = loop.step();
    output.elements.status.converter_saturated = n % 17000 == 16500;
    fit.add(output.elements, output.gains);
    if (const auto estimate = identifier.process(output.elements, output.gains)) last = *estimate;
  }
  const BatchEstimate estimate = fit.solve();
  EXPECT_TRUE(estimate.converged);
  EXPECT_NEAR(estimate.chi_square / estimate.residuals, 1.0,
              4.0 * std::sqrt(2.0 / estimate.residuals));
  for (Eigen::Index k = 4; k < estimate.value.size(); ++k) {
    const double sigma = std::sqrt(estimate.covariance(k, k));
    // The filter uses neither its first period nor a period with a gap.
    EXPECT_NEAR(last.sigma(k) / sigma, 1.0, 0.03) << k;
    EXPECT_NEAR(last.value[k], estimate.value[k], 0.5 * sigma) << k;
  }
}

TEST(BatchLeastSquares, SaysWhenThereIsNothingToFit) {
  BatchLeastSquares fit(toldOf(AveragedLoop::Options()), noisy(), ConverterParameters());
  EXPECT_THROW(fit.solve(), std::runtime_error);
}

}  // namespace
}  // namespace cvg
