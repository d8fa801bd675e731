#include "ring_gyro/nodes/decision_queue.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace ring_gyro {
namespace {

constexpr std::uint64_t kPeriod = 100;
constexpr std::uint32_t kSession = 7;

struct Decision {
  std::uint32_t session = kSession;
  std::uint64_t effective_sequence = 0;
  int value = 0;
};

class DecisionQueueTest : public ::testing::Test {
 protected:
  std::vector<int> applied(std::uint64_t acts_in, std::uint32_t session = kSession) {
    std::vector<int> values;
    queue_.applyDue(session, acts_in,
                    [&](const Decision& decision) { values.push_back(decision.value); });
    return values;
  }

  DecisionQueue<Decision> queue_{kPeriod};
};

TEST_F(DecisionQueueTest, NothingIsDueInTheFirstTwoPeriods) {
  for (std::uint64_t block = 0; block < 2 * kPeriod; ++block) {
    EXPECT_FALSE(queue_.mustWaitFor(kSession, block)) << block;
  }
}

TEST_F(DecisionQueueTest, OnlyTheFirstBlockOfAPeriodWaits) {
  for (std::uint64_t block = 2 * kPeriod; block <= 4 * kPeriod; ++block) {
    EXPECT_EQ(queue_.mustWaitFor(kSession, block), block % kPeriod == 0) << block;
  }
}

TEST_F(DecisionQueueTest, WaitsForTheDecisionOfThisBlockAndNoOther) {
  queue_.add({kSession, 300, 1});
  EXPECT_TRUE(queue_.mustWaitFor(kSession, 200));
  queue_.add({kSession + 1, 200, 2});
  EXPECT_TRUE(queue_.mustWaitFor(kSession, 200));
  queue_.add({kSession, 200, 3});
  EXPECT_FALSE(queue_.mustWaitFor(kSession, 200));
}

TEST_F(DecisionQueueTest, AppliesEachDecisionOnceFromItsBlockOn) {
  queue_.add({kSession, 200, 1});
  queue_.add({kSession, 300, 2});
  EXPECT_TRUE(applied(199).empty());
  EXPECT_EQ(applied(200), std::vector<int>{1});
  EXPECT_TRUE(applied(201).empty());
  EXPECT_EQ(applied(300), std::vector<int>{2});
  EXPECT_EQ(queue_.counts().late, 0u);
  EXPECT_EQ(queue_.counts().foreign, 0u);
}

TEST_F(DecisionQueueTest, ALateDecisionIsCountedAndAppliedWithTheNextBlock) {
  EXPECT_TRUE(applied(200).empty());
  queue_.add({kSession, 200, 1});
  EXPECT_EQ(queue_.counts().late, 1u);
  EXPECT_EQ(applied(201), std::vector<int>{1});
}

TEST_F(DecisionQueueTest, DecisionsOfAnotherSessionAreCountedAndLeftOut) {
  queue_.add({kSession - 1, 200, 1});  // before any block: it may yet be the session
  EXPECT_EQ(queue_.counts().foreign, 0u);
  EXPECT_TRUE(applied(200).empty());
  EXPECT_EQ(queue_.counts().foreign, 1u);
  queue_.add({kSession - 1, 300, 2});
  EXPECT_EQ(queue_.counts().foreign, 2u);
  EXPECT_TRUE(applied(300).empty());
}

TEST_F(DecisionQueueTest, WhatAnEarlierRunLeftBehindHoldsNothingUp) {
  queue_.add({kSession - 1, 500000, 1});
  queue_.add({kSession, 200, 2});
  EXPECT_EQ(applied(200), std::vector<int>{2});
  EXPECT_EQ(queue_.counts().foreign, 1u);
}

}  // namespace
}  // namespace ring_gyro
