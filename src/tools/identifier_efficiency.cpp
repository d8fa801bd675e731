// Compares the errors of the extended identifier with the posterior Cramer-Rao bound: many seeds of
// the closed loop of a configuration with ideal electronics (noise and the drive's gain matrix may
// be on).
//
//   identifier_efficiency CONFIG.yaml SEEDS [section/key=value ...]

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "ring_gyro/common/number_text.h"
#include "ring_gyro/common/parallel_for.h"
#include "ring_gyro/configuration/configuration_reader.h"
#include "ring_gyro/control/control_loops.h"
#include "ring_gyro/identification/filter/extended_identifier.h"
#include "ring_gyro/identification/filter/extended_prior.h"
#include "ring_gyro/identification/judge/information_bound.h"
#include "ring_gyro/resonator/plant_simulator.h"

namespace ring_gyro::tools {
namespace {

using Complex = std::complex<double>;

/// Calls `seen` with every block of a run: the output of the loops, and k Om.
template <typename Seen>
void runLoop(const cvg::LoopConfiguration& configuration, std::uint64_t seed, const Seen& seen) {
  cvg::PlantSimulator plant(configuration.plant, configuration.converter, seed, 1, 1000000000);
  cvg::ControlLoops loops(configuration.device, configuration.control, configuration.demodulation,
                          configuration.converter);
  const cvg::DisplacementBlock* block = &plant.start();
  const std::uint64_t blocks = configuration.run.blocks(configuration.converter);
  for (std::uint64_t n = 0; n < blocks; ++n) {
    const cvg::LoopOutput& output = loops.process(*block);
    seen(output, configuration.plant.resonator.angular_gain * plant.truth().rotation_rate);
    block = &plant.step(output.command);
  }
}

/// Truth of the states, for electronics whose only error is a gain matrix of the drive.
cvg::ExtendedVector truthOf(const cvg::ExtendedState& state,
                            const cvg::LoopConfiguration& configuration) {
  const cvg::ResonatorParameters ring = configuration.plant.resonator.tuned();
  const cvg::AxisErrors& axes = configuration.plant.drive.axes;
  Eigen::Matrix2cd matrix = ring.driveGain() * axes.gainMatrix().cast<Complex>();
  for (int k = 0; k < 2; ++k) matrix.col(k) *= std::polar(1.0, -axes.phaseDelays()[k]);
  const Complex gain = 0.5 * (matrix(0, 0) + matrix(1, 1));
  const Complex mismatch = 0.5 * (matrix(0, 0) - matrix(1, 1)) / gain;
  const Complex skew = 0.5 * (matrix(0, 1) + matrix(1, 0)) / gain;
  const Complex turn = 0.5 * (matrix(0, 1) - matrix(1, 0)) / gain;

  const cvg::ExtendedState::Layout& at = state.layout();
  cvg::ExtendedVector truth = cvg::ExtendedVector::Zero(state.size());
  truth.segment<5>(at.gamma) << ring.gamma1, ring.gamma2, ring.mu1, ring.mu2, std::abs(gain);
  if (at.decay_rate >= 0) truth[at.decay_rate] = ring.decayRate();
  if (at.frequency >= 0) truth[at.frequency] = ring.natural_frequency;
  if (at.drive_phase >= 0) truth[at.drive_phase] = -std::arg(gain);
  if (at.mismatch >= 0) {
    truth.segment<4>(at.mismatch) << mismatch.real(), skew.real(), mismatch.imag(), skew.imag();
  }
  if (at.drive_rotation >= 0) truth.segment<2>(at.drive_rotation) << turn.real(), turn.imag();
  if (at.pickoff_cubic >= 0) truth[at.pickoff_cubic] = configuration.plant.sense.cubic;
  return truth;
}

double processNoise(const cvg::PlantParameters& plant) {
  const double density = std::hypot(plant.resonator.thermal_noise_density,
                                    plant.drive.zero_order_hold ? 0.0 : plant.drive.noise_density);
  return 0.5 * plant.resonator.driveGain() * density / plant.resonator.angularFrequency();
}

cvg::ExtendedMatrix boundOf(cvg::LoopConfiguration configuration, const cvg::ExtendedState& state,
                            const cvg::ExtendedVector& truth) {
  const cvg::PlantParameters noisy = configuration.plant;
  configuration.plant.sense.noise_density = 0.0;
  configuration.plant.drive.noise_density = 0.0;
  configuration.plant.resonator.thermal_noise_density = 0.0;
  cvg::ExtendedVector sigma = cvg::priorSigma(state, configuration.extended, truth);
  sigma.head<4>().setOnes();
  cvg::EnvelopeBound bound(cvg::EnvelopeModel(state), truth, sigma, noisy.sense.noise_density,
                           processNoise(noisy), configuration.converter);
  runLoop(configuration, 1, [&bound](const cvg::LoopOutput& output, double rotation) {
    bound.process(output.elements, output.gains, rotation);
  });
  return bound.covariance();
}

struct Statistics {
  explicit Statistics(Eigen::Index size)
      : square(Eigen::ArrayXd::Zero(size)),
        sum(Eigen::ArrayXd::Zero(size)),
        variance(Eigen::ArrayXd::Zero(size)),
        covered(Eigen::ArrayXd::Zero(size)) {}

  Eigen::ArrayXd square;
  Eigen::ArrayXd sum;
  Eigen::ArrayXd variance;
  Eigen::ArrayXd covered;
  double nees = 0.0;
  double nis = 0.0;
  double updates = 0.0;
};

void addSeed(const cvg::LoopConfiguration& configuration, const cvg::ExtendedVector& truth,
             std::uint64_t seed, std::mutex& mutex, Statistics& statistics) {
  cvg::ExtendedIdentifier identifier(configuration.device, configuration.extended,
                                     configuration.converter);
  cvg::ExtendedEstimate last;
  double nis = 0.0;
  double updates = 0.0;
  runLoop(configuration, seed, [&](const cvg::LoopOutput& output, double rotation) {
    const auto estimate = identifier.process(output.elements, output.gains, rotation);
    if (!estimate) return;
    last = *estimate;
    if (!estimate->settled || !estimate->updated || !estimate->whole_period) return;
    nis += estimate->normalised_innovation_squared;
    updates += 1.0;
  });
  if (!last.settled) throw std::runtime_error("the identifier has not settled; run longer");
  const Eigen::Index size = truth.size() - 4;
  const Eigen::VectorXd error = (last.value - truth).tail(size);
  const Eigen::MatrixXd covariance = last.covariance.bottomRightCorner(size, size);
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
  const Eigen::MatrixXd correlation = covariance.cwiseQuotient(sigma * sigma.transpose());
  const Eigen::VectorXd scaled = error.cwiseQuotient(sigma);
  const std::lock_guard<std::mutex> lock(mutex);
  statistics.square += error.array().square();
  statistics.sum += error.array();
  statistics.variance += sigma.array().square();
  statistics.covered += (scaled.array().abs() < 1.959964).cast<double>();
  statistics.nees += scaled.dot(correlation.ldlt().solve(scaled));
  statistics.nis += nis;
  statistics.updates += updates;
}

void run(cvg::LoopConfiguration configuration, std::uint64_t seeds) {
  configuration.extended.noise_density = configuration.plant.sense.noise_density;
  configuration.extended.envelope_process_noise = processNoise(configuration.plant);
  const cvg::ExtendedState state(configuration.device, configuration.extended);
  const cvg::ExtendedVector truth = truthOf(state, configuration);
  const cvg::ExtendedMatrix bound = boundOf(configuration, state, truth);

  const Eigen::Index size = state.size() - 4;
  Statistics statistics(size);
  std::mutex mutex;
  cvg::parallelFor(seeds, cvg::coreCount(),
                   [&](std::size_t k) { addSeed(configuration, truth, k + 1, mutex, statistics); });

  const double count = static_cast<double>(seeds);
  std::printf(
      "%.0f s, %llu seeds. NEES %.2f, expected %d, 95 %% within +- %.2f; NIS %.4f, expected 4, "
      "95 %% within +- %.4f\n",
      configuration.run.duration, static_cast<unsigned long long>(seeds), statistics.nees / count,
      static_cast<int>(size), 1.96 * std::sqrt(2.0 * static_cast<double>(size) / count),
      statistics.nis / statistics.updates, 1.96 * std::sqrt(8.0 / statistics.updates));
  std::printf("%-22s %10s %10s %10s %10s %12s %10s %9s\n", "", "truth", "bound", "sigma", "rmse",
              "rmse/bound", "bias/rmse", "coverage");
  for (Eigen::Index k = 0; k < size; ++k) {
    const double rmse = std::sqrt(statistics.square[k] / count);
    const double limit = std::sqrt(bound(k + 4, k + 4));
    std::printf("%-22s %10.3g %10.2e %10.2e %10.2e %12.3f %10.2f %8.1f %%\n",
                state.names()[static_cast<std::size_t>(k + 4)].c_str(), truth[k + 4], limit,
                std::sqrt(statistics.variance[k] / count), rmse, rmse / limit,
                statistics.sum[k] / count / rmse, 100.0 * statistics.covered[k] / count);
  }
}

}  // namespace
}  // namespace ring_gyro::tools

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr,
                 "usage: identifier_efficiency CONFIG.yaml SEEDS [section/key=value ...]\n");
    return EXIT_FAILURE;
  }
  try {
    const std::vector<std::string> overrides(argv + 3, argv + argc);
    const std::optional<double> seeds = cvg::parseNumber(argv[2]);
    if (!seeds || !(*seeds >= 1.0 && *seeds <= 1e9) || *seeds != std::floor(*seeds)) {
      throw std::invalid_argument(std::string(argv[2]) + ": is no number of seeds; 1 to 1e9");
    }
    ring_gyro::tools::run(cvg::readConfigurationFile(argv[1], overrides),
                          static_cast<std::uint64_t>(*seeds));
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "identifier_efficiency: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
