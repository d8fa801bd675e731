#include "ring_gyro/simulation/monte_carlo.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <stdexcept>

#include "ring_gyro/common/parallel_for.h"
#include "ring_gyro/simulation/closed_loop.h"
#include "ring_gyro/simulation/random_device.h"

namespace cvg {
namespace {

constexpr double kTwoSided95 = 1.959963984540054;  // standard deviations

void run(const LoopConfiguration& configuration, MonteCarloItem& item) {
  const ResonatorParameters ring = configuration.plant.resonator.tuned();
  item.natural_frequency = ring.natural_frequency;
  item.quality_factor = ring.quality_factor;
  item.virtual_rate = configuration.control.virtual_rate;
  item.duration = configuration.run.duration;
  item.truth = {ring.gamma1, ring.gamma2, ring.mu1, ring.mu2, ring.driveGain()};

  ClosedLoop loop(configuration);
  const std::uint64_t blocks = configuration.run.blocks(configuration.converter);
  bool locked = false;
  double innovations = 0.0;
  ParameterEstimate last;
  for (std::uint64_t block = 0; block < blocks; ++block) {
    const LoopRecord now = loop.step();
    if (!locked && now.loops.elements.status.locked()) {
      locked = true;
      item.locked_after = loop.time();
    }
    if (!now.estimate) continue;
    last = *now.estimate;
    if (!last.updated) continue;
    ++item.updates;
    innovations += last.normalised_innovation_squared;
  }
  if (!locked) {
    item.refused = "the loops have not locked";
  } else if (item.updates == 0) {
    item.refused = "locked, but never long enough for the identifier";
  }
  if (!item.refused.empty()) return;
  item.converged = last.converged;
  item.used_blocks = last.used_blocks;
  item.rejected_blocks = last.rejected_blocks;
  item.mean_normalised_innovation_squared = innovations / static_cast<double>(item.updates);
  for (std::size_t k = 0; k < item.estimate.size(); ++k) {
    const auto state = static_cast<StateIndex>(kGamma1 + static_cast<int>(k));
    item.estimate[k] = last.value[state];
    item.sigma[k] = last.sigma(state);
  }
}

}  // namespace

MonteCarloItem runMonteCarloItem(const MonteCarlo& batch, std::uint64_t index) {
  MonteCarloItem item;
  item.index = index;
  item.seed = batch.configuration.run.seed + static_cast<std::int64_t>(index);
  try {
    LoopConfiguration configuration =
        batch.random_devices ? randomDevice(batch.configuration, index) : batch.configuration;
    configuration.run.seed = item.seed;
    if (configuration.run.blocks(configuration.converter) == 0) {
      throw std::invalid_argument("run/duration: a batch needs one that ends");
    }
    run(configuration, item);
  } catch (const std::invalid_argument& reason) {
    item.refused = reason.what();
  } catch (const std::domain_error& reason) {
    item.refused = reason.what();
  }
  return item;
}

void runMonteCarlo(const MonteCarlo& batch, const std::vector<std::uint64_t>& indices,
                   std::size_t threads,
                   const std::function<void(const MonteCarloItem&)>& finished) {
  std::mutex mutex;
  bool failed = false;  // then items that still run are not reported
  parallelFor(indices.size(), threads, [&](std::size_t n) {
    const MonteCarloItem item = runMonteCarloItem(batch, indices[n]);
    const std::lock_guard<std::mutex> lock(mutex);
    if (failed) return;
    failed = true;
    finished(item);
    failed = false;
  });
}

MonteCarloSummary summarise(const std::vector<MonteCarloItem>& items) {
  MonteCarloSummary summary;
  double count = 0.0;
  double updates = 0.0;
  for (const MonteCarloItem& item : items) {
    ++summary.items;
    if (!item.refused.empty()) {
      ++summary.refused;
      continue;
    }
    count += 1.0;
    if (item.converged) ++summary.converged;
    updates += static_cast<double>(item.updates);
    summary.mean_normalised_innovation_squared +=
        static_cast<double>(item.updates) * item.mean_normalised_innovation_squared;
    for (std::size_t k = 0; k < item.truth.size(); ++k) {
      const double scale = k + 1 == item.truth.size() ? 1.0 / item.truth[k] : 1.0;
      const double error = scale * (item.estimate[k] - item.truth[k]);
      const double sigma = scale * item.sigma[k];
      ParameterStatistics& statistics = summary.parameters[k];
      statistics.mean_error += error;
      statistics.root_mean_square_error += error * error;
      statistics.mean_sigma += sigma;
      if (std::abs(error) <= kTwoSided95 * sigma) statistics.coverage += 1.0;
    }
  }
  if (count == 0.0) return summary;
  summary.mean_normalised_innovation_squared /= updates;
  for (ParameterStatistics& statistics : summary.parameters) {
    statistics.mean_error /= count;
    statistics.root_mean_square_error = std::sqrt(statistics.root_mean_square_error / count);
    statistics.mean_sigma /= count;
    statistics.coverage /= count;
  }
  return summary;
}

}  // namespace cvg
