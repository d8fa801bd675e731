#include "ring_gyro/simulation/monte_carlo.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "ring_gyro/common/item_range.h"
#include "ring_gyro/configuration/configuration_reader.h"
#include "ring_gyro/simulation/random_device.h"

namespace cvg {
namespace {

MonteCarlo batchOf(const char* duration) {
  MonteCarlo batch;
  batch.configuration =
      readConfigurationFile(RING_GYRO_CONFIG_DIR "/paper_simulation.yaml",
                            {std::string("run/duration=") + duration, "run/seed=10"});
  return batch;
}

TEST(MonteCarlo, ShardsAreDisjointAndLeaveNothingOut) {
  std::set<std::uint64_t> seen;
  for (std::uint64_t shard = 0; shard < 3; ++shard) {
    for (const std::uint64_t index : ItemRange{5, 20, shard, 3}.indices()) {
      EXPECT_EQ(index % 3, shard);
      EXPECT_TRUE(seen.insert(index).second);
    }
  }
  EXPECT_EQ(seen.size(), 20u);
  EXPECT_EQ(*seen.begin(), 5u);
  EXPECT_EQ(*seen.rbegin(), 24u);
  EXPECT_THROW((ItemRange{0, 1, 3, 3}.indices()), std::invalid_argument);
}

TEST(MonteCarlo, ItemsDependOnNothingButTheirIndex) {
  const MonteCarlo batch = batchOf("3");
  std::map<std::uint64_t, MonteCarloItem> items;
  runMonteCarlo(batch, {4, 1, 3, 2}, 2,
                [&items](const MonteCarloItem& item) { items[item.index] = item; });
  ASSERT_EQ(items.size(), 4u);
  for (const std::uint64_t index : {1u, 2u, 3u, 4u}) {
    const MonteCarloItem alone = runMonteCarloItem(batch, index);
    EXPECT_EQ(alone.refused, "");
    EXPECT_EQ(alone.seed, 10 + static_cast<std::int64_t>(index));
    EXPECT_EQ(items.at(index).estimate, alone.estimate);
    EXPECT_EQ(items.at(index).sigma, alone.sigma);
  }
  EXPECT_NE(items.at(1).estimate, items.at(2).estimate);
}

TEST(MonteCarlo, SaysWhyAnItemCannotBeRun) {
  MonteCarlo batch = batchOf("0.5");
  batch.configuration.control.drive_limit = 0.05;
  const MonteCarloItem item = runMonteCarloItem(batch, 0);
  EXPECT_EQ(item.refused, "the loops have not locked");
  EXPECT_EQ(summarise({item}).refused, 1u);
}

TEST(MonteCarlo, ThrowsOnWhatTheReaderOfItemsThrows) {
  EXPECT_THROW(runMonteCarlo(batchOf("0.1"), {0, 1, 2}, 2,
                             [](const MonteCarloItem&) { throw std::runtime_error("disk full"); }),
               std::runtime_error);
}

TEST(MonteCarlo, Summary) {
  MonteCarloItem low, high;
  low.truth = high.truth = {1.0, 1.0, 1.0, 1.0, 100.0};
  low.sigma = high.sigma = {0.1, 0.1, 0.1, 0.1, 1.0};
  low.estimate = {0.9, 1.0, 1.0, 1.0, 99.0};
  high.estimate = {1.3, 1.0, 1.0, 1.0, 99.0};
  low.updates = 10;
  low.mean_normalised_innovation_squared = 1.0;
  high.updates = 30;
  high.mean_normalised_innovation_squared = 3.0;
  const MonteCarloSummary summary = summarise({low, high});
  EXPECT_EQ(summary.items, 2u);
  EXPECT_NEAR(summary.parameters[0].mean_error, 0.1, 1e-12);
  EXPECT_NEAR(summary.parameters[0].root_mean_square_error, std::sqrt(0.05), 1e-12);
  EXPECT_NEAR(summary.parameters[0].coverage, 0.5, 1e-12);
  EXPECT_NEAR(summary.parameters[4].mean_error, -0.01, 1e-12);
  EXPECT_NEAR(summary.parameters[4].mean_sigma, 0.01, 1e-12);
  EXPECT_NEAR(summary.mean_normalised_innovation_squared, 2.5, 1e-12);
}

TEST(RandomDevice, IsDrawnFromTheStatedRanges) {
  const LoopConfiguration base = batchOf("1").configuration;
  int usable = 0;
  double least_q = 1e9, most_q = 0.0, most_gamma = 0.0;
  for (std::uint64_t index = 0; index < 1000; ++index) {
    LoopConfiguration device;
    try {
      device = randomDevice(base, index);
    } catch (const std::invalid_argument&) {
      continue;
    }
    ++usable;
    const ResonatorParameters& ring = device.plant.resonator;
    const double gamma = std::hypot(ring.gamma1, ring.gamma2);
    ASSERT_TRUE(ring.natural_frequency >= 3e3 && ring.natural_frequency <= 100e3);
    ASSERT_LE(gamma, 0.1);
    ASSERT_LE(std::hypot(ring.mu1, ring.mu2), 1e-4);
    ASSERT_GE(device.converter.sample_rate, 8.0 * ring.natural_frequency);
    ASSERT_EQ(device.converter.blockDurationNanoseconds(), 1000000);
    ASSERT_GT(std::abs(device.control.virtual_rate), 3.0 * ring.decayRate() * gamma);
    ASSERT_GE(device.run.duration, 10.0 / ring.decayRate());
    least_q = std::min(least_q, ring.quality_factor);
    most_q = std::max(most_q, ring.quality_factor);
    most_gamma = std::max(most_gamma, gamma);
  }
  EXPECT_GT(usable, 900);
  EXPECT_LT(least_q, 6e3);
  EXPECT_GT(most_q, 0.9e6);
  EXPECT_GT(most_gamma, 0.09);
  EXPECT_EQ(randomDevice(base, 7).plant.resonator.gamma1,
            randomDevice(base, 7).plant.resonator.gamma1);
}

}  // namespace
}  // namespace cvg
