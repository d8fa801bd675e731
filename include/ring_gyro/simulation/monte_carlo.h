#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "ring_gyro/simulation/loop_configuration.h"

namespace cvg {

/// Definition of the batch: item n is the run of `configuration` with seed run.seed + n and, if
/// requested, the random device of index n.
struct MonteCarlo {
  LoopConfiguration configuration;
  bool random_devices = false;
};

/// The identified parameters in the order of (29), gamma1, gamma2, mu1, mu2, ks.
constexpr std::array<const char*, 5> kMonteCarloParameters = {"gamma1", "gamma2", "mu1", "mu2",
                                                              "drive_gain"};

/// Outcome of one run.
struct MonteCarloItem {
  std::uint64_t index = 0;
  std::int64_t seed = 0;
  std::string refused;             ///< why it was not run or identified; empty if it was
  double natural_frequency = 0.0;  ///< of the device [Hz]
  double quality_factor = 0.0;
  double virtual_rate = 0.0;  ///< steering [rad/s]
  double duration = 0.0;      ///< simulated [s]
  double locked_after = 0.0;  ///< [s]
  bool converged = false;
  std::uint64_t used_blocks = 0;
  std::uint64_t rejected_blocks = 0;
  std::array<double, 5> truth{};
  std::array<double, 5> estimate{};
  std::array<double, 5> sigma{};
  std::uint64_t updates = 0;
  double mean_normalised_innovation_squared = 0.0;  ///< expected: 2
};

/// Runs one item. If configuration or device do not allow the run, `refused` gives the reason.
MonteCarloItem runMonteCarloItem(const MonteCarlo& batch, std::uint64_t index);

/// Runs the items on `threads` threads. `finished` is called for each item when it ends, one call
/// at a time, in any order. An exception of `finished` or of an item ends the batch and is
/// rethrown.
void runMonteCarlo(const MonteCarlo& batch, const std::vector<std::uint64_t>& indices,
                   std::size_t threads, const std::function<void(const MonteCarloItem&)>& finished);

/// Errors of one parameter over many items; of ks relative to its truth.
struct ParameterStatistics {
  double mean_error = 0.0;
  double root_mean_square_error = 0.0;
  double mean_sigma = 0.0;
  double coverage = 0.0;  ///< share of items whose 95 % interval contains the truth
};

struct MonteCarloSummary {
  std::uint64_t items = 0;
  std::uint64_t refused = 0;
  std::uint64_t converged = 0;
  std::array<ParameterStatistics, 5> parameters;  ///< over the items that were not refused
  double mean_normalised_innovation_squared = 0.0;
};

MonteCarloSummary summarise(const std::vector<MonteCarloItem>& items);

}  // namespace cvg
