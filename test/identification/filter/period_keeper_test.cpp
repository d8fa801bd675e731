#include "ring_gyro/identification/filter/period_keeper.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>

namespace cvg {
namespace {

constexpr std::int64_t kPeriod = 10;
using Follows = PeriodKeeper::Follows;

BlockStamp at(std::uint64_t sequence, std::uint32_t session = 1) {
  return {session, sequence, static_cast<std::int64_t>(sequence + 1) * 1000000, 1000000};
}

TEST(PeriodKeeper, EndsPeriodsWhereTheSequenceSaysWheneverItWasStarted) {
  PeriodKeeper periods(kPeriod);
  for (std::uint64_t n = 7; n < 57; ++n) {
    EXPECT_EQ(periods.follow(at(n)), n == 7 ? Follows::kNothing : Follows::kDirectly);
    EXPECT_EQ(periods.atFirstBlock(), n % 10 == 0) << n;
    EXPECT_EQ(periods.atLastBlock(), n % 10 == 9) << n;
    EXPECT_EQ(periods.complete(), n >= 10) << n;
    periods.see(0.1 * static_cast<double>(n));
    if (periods.atLastBlock()) periods.finish(periods.complete());
  }
  EXPECT_EQ(periods.firstSequence(), 7u);
  EXPECT_EQ(periods.rejected(), 3u);
  EXPECT_EQ(periods.used(), 40u);
  EXPECT_NEAR(periods.angleCovered(), 3.9, 1e-12);  // from blocks 10 to 49
}

TEST(PeriodKeeper, APeriodWithAGapOrASpoiltBlockIsNotComplete) {
  PeriodKeeper periods(kPeriod);
  periods.follow(at(0));
  EXPECT_TRUE(periods.complete());
  EXPECT_EQ(periods.follow(at(5)), Follows::kAfterGap);
  EXPECT_FALSE(periods.complete());
  EXPECT_EQ(periods.lost(), 4u);
  EXPECT_EQ(periods.follow(at(20)), Follows::kAfterGap);  // the first of its period
  EXPECT_TRUE(periods.complete());
  EXPECT_EQ(periods.lost(), 18u);
  EXPECT_EQ(periods.rejected(), 2u);  // blocks of the period whose end was lost
  periods.spoil();
  EXPECT_FALSE(periods.complete());
  periods.follow(at(21));
  EXPECT_FALSE(periods.complete());
}

TEST(PeriodKeeper, StartsAfreshWithASessionAndWhenTheSequenceDoesNotGrow) {
  PeriodKeeper periods(kPeriod);
  periods.follow(at(100));
  EXPECT_EQ(periods.restarts(), 0u);
  EXPECT_EQ(periods.follow(at(101, 2)), Follows::kNothing);
  EXPECT_EQ(periods.follow(at(101, 2)), Follows::kNothing);
  EXPECT_EQ(periods.follow(at(3, 2)), Follows::kNothing);
  EXPECT_EQ(periods.restarts(), 3u);
  EXPECT_EQ(periods.firstSequence(), 3u);
  EXPECT_EQ(periods.lost() + periods.used() + periods.rejected(), 0u);
}

TEST(PeriodKeeper, AccountsForEveryBlockWhateverIsMissing) {
  std::mt19937 random(3);
  PeriodKeeper periods(kPeriod);
  std::uint64_t n = 4;
  for (int k = 0; k < 5000; ++k, n += random() % 5 == 0 ? random() % 40 + 1 : 1) {
    periods.follow(at(n));
    if (random() % 20 == 0) periods.spoil();
    periods.see(1.0);
    if (!periods.atLastBlock()) continue;
    periods.finish(periods.complete() && random() % 3 > 0);
    EXPECT_EQ(periods.used() + periods.rejected() + periods.lost(),
              n + 1 - periods.firstSequence());
    EXPECT_EQ(periods.used() % kPeriod, 0u);
  }
  EXPECT_GT(periods.used(), 100u);
  EXPECT_GT(periods.lost(), 100u);
}

}  // namespace
}  // namespace cvg
