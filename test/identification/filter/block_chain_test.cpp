#include "ring_gyro/identification/filter/block_chain.h"

#include <gtest/gtest.h>

#include <utility>

#include "ring_gyro/common/angle.h"

namespace cvg {
namespace {

constexpr std::int64_t kBlock = 1000000;
constexpr std::uint64_t kFirst = 1000;

/// Admits a usable block whose drive along x is its sequence number.
BlockUse admit(BlockChain& chain, std::uint64_t sequence, double delay_blocks) {
  OrbitalElements elements;
  elements.stamp = {1, sequence, static_cast<std::int64_t>(sequence + 1) * kBlock, kBlock};
  elements.group_delay = 1e-3 * delay_blocks;
  elements.orbit = {1.0, 0.0, 0.3, -kPi / 2};
  elements.status.amplitude_locked = elements.status.quadrature_locked =
      elements.status.phase_locked = true;
  ControlGains gains;
  gains.stamp = elements.stamp;
  gains.status = elements.status;
  gains.reference_frequency = kTwoPi * 14e3;
  gains.drive.sustain.x() = static_cast<double>(sequence);
  return chain.admit(elements, gains, 0.0);
}

TEST(BlockChain, StepsHaveTheDriveThatActedADelayBefore) {
  for (const double delay : {0.0, 1.0, 30.0, 31.0}) {
    SCOPED_TRACE(delay);
    BlockChain chain(kBlock);
    bool before = false;
    for (std::uint64_t last = kFirst; last < kFirst + 300; ++last) {
      const BlockUse use = admit(chain, last, delay);
      const bool usable = use == BlockUse::kUsable;
      EXPECT_TRUE(usable || use == BlockUse::kAfterBreak);
      EXPECT_EQ(usable, static_cast<double>(last - kFirst + 1) >= 2.0 * delay) << last;
      // A step needs a usable block at both ends.
      if (!std::exchange(before, usable) || !usable) continue;
      const double acted = static_cast<double>(last) - delay;
      ASSERT_NEAR(chain.step(0.0).x.re, acted, 1e-12 * acted) << last;
      EXPECT_EQ(chain.segments()[1].input.reference_frequency, kTwoPi * 14e3);
    }
  }
}

TEST(BlockChain, DriveOfTwoBlocksActsWhereTheDelayIsNotWhole) {
  BlockChain chain(kBlock);
  for (std::uint64_t n = kFirst; n < kFirst + 200; ++n) admit(chain, n, 30.5);
  EXPECT_NEAR(chain.step(0.0).x.re, static_cast<double>(kFirst + 199) - 30.5, 1e-9);
}

// Without a delay the first block after a gap can be used, but no step leads to it.
TEST(BlockChain, KnowsWhetherABlockFollowsTheOneBefore) {
  BlockChain chain(kBlock);
  const auto admitted = [&](std::uint64_t sequence) {
    EXPECT_EQ(admit(chain, sequence, 0.0), BlockUse::kUsable) << sequence;
    return chain.follows();
  };
  EXPECT_FALSE(admitted(kFirst));
  EXPECT_TRUE(admitted(kFirst + 1));
  EXPECT_FALSE(admitted(kFirst + 3));
  EXPECT_TRUE(admitted(kFirst + 4));
}

TEST(BlockChain, RefusesDelaysLongerThanItsMemory) {
  BlockChain chain(kBlock);
  for (std::uint64_t n = kFirst; n < kFirst + 300; ++n)
    EXPECT_EQ(admit(chain, n, 31.5), BlockUse::kGroupDelay) << n;
  for (std::uint64_t n = kFirst + 300; n < kFirst + 600; ++n) {
    EXPECT_EQ(admit(chain, n, -1.0), BlockUse::kImpossible) << n;
  }
}

}  // namespace
}  // namespace cvg
