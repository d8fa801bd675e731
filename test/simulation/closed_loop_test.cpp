#include "ring_gyro/simulation/closed_loop.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "ring_gyro/configuration/configuration_reader.h"
#include "ring_gyro/signals/compensation_decision.h"

namespace cvg {
namespace {

LoopConfiguration configuration(const std::vector<std::string>& overrides) {
  return readConfigurationFile(RING_GYRO_CONFIG_DIR "/paper_simulation.yaml", overrides);
}

TEST(ClosedLoop, IsReproducible) {
  const LoopConfiguration twice = configuration({"control/compensation=true", "run/seed=5"});
  ClosedLoop a(twice);
  ClosedLoop b(twice);
  for (int block = 0; block < 1500; ++block) {
    const LoopRecord record_a = a.step();
    const LoopRecord record_b = b.step();
    ASSERT_EQ(record_a.displacement.x, record_b.displacement.x);
    ASSERT_EQ(record_a.loops.command.envelope, record_b.loops.command.envelope);
    ASSERT_EQ(record_a.estimate != nullptr, record_b.estimate != nullptr);
    if (record_a.estimate) {
      ASSERT_EQ(record_a.estimate->value, record_b.estimate->value);
    }
  }
  EXPECT_NEAR(a.time(), 1.5, 1e-9);
}

TEST(ClosedLoop, SeedChangesTheNoise) {
  ClosedLoop a(configuration({"run/seed=1"}));
  ClosedLoop b(configuration({"run/seed=2"}));
  EXPECT_NE(a.step().displacement.x, b.step().displacement.x);
}

// The second: each block brings an estimate and a decision.
TEST(ClosedLoop, DecisionsActAPeriodAfterTheirData) {
  for (const char* update_period : {"0.1", "0.001"}) {
    SCOPED_TRACE(update_period);
    const LoopConfiguration compensated =
        configuration({"control/compensation=true",
                       std::string("identification/update_period=") + update_period});
    ClosedLoop loop(compensated);
    const std::uint64_t period = compensated.periodBlocks();
    constexpr std::uint64_t kBlocks = 20000;
    std::vector<CompensationDecision> decisions;
    std::size_t acting = 0;
    DampingCompensation expected;
    bool compensated_once = false;
    for (std::uint64_t block = 0; block < kBlocks; ++block) {
      const LoopRecord record = loop.step();
      // What acts in this block was decided for it or for one before.
      for (; acting < decisions.size() && decisions[acting].effective_sequence == block; ++acting) {
        expected = decisions[acting].gains;
      }
      if (record.loops.gains.status.locked() && record.loops.gains.compensation.gain1 != 0.0) {
        EXPECT_EQ(record.loops.gains.compensation.gain1, expected.gain1) << block;
        compensated_once = true;
      }
      if (!record.decision) continue;
      EXPECT_EQ((record.decision->data_sequence + 1) % period, 0u);
      EXPECT_EQ(record.decision->effective_sequence, record.decision->data_sequence + 1 + period);
      decisions.push_back(*record.decision);
    }
    EXPECT_EQ(decisions.size(), kBlocks / period);
    EXPECT_TRUE(compensated_once);
  }
}

}  // namespace
}  // namespace cvg
