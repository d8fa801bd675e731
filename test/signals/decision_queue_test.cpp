#include "ring_gyro/signals/decision_queue.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace cvg {
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

TEST_F(DecisionQueueTest, ABlockWhoseDecisionHasBeenUsedUpDoesNotWaitAgain) {
  for (std::uint64_t block = 1; block < 200; ++block) EXPECT_TRUE(applied(block).empty());
  queue_.add({kSession, 200, 1});
  EXPECT_EQ(applied(200), std::vector<int>{1});
  EXPECT_FALSE(queue_.mustWaitFor(kSession, 200)) << "the same block again";
  for (std::uint64_t block = 201; block < 300; ++block) EXPECT_TRUE(applied(block).empty());
  EXPECT_TRUE(queue_.mustWaitFor(kSession, 300));
  EXPECT_FALSE(queue_.mustWaitFor(kSession, 200)) << "an old block";
}

TEST_F(DecisionQueueTest, NothingIsDueFromDataThatTheNodeHasNotSeen) {
  EXPECT_TRUE(applied(1).empty());
  EXPECT_TRUE(queue_.mustWaitFor(kSession, 400));
  EXPECT_FALSE(queue_.mustWaitFor(kSession + 1, 400)) << "a block of another session";
  // A new session that this node joins in the middle.
  EXPECT_TRUE(applied(351, kSession + 1).empty());
  EXPECT_FALSE(queue_.mustWaitFor(kSession + 1, 400));
  EXPECT_TRUE(queue_.mustWaitFor(kSession + 1, 500));
  EXPECT_FALSE(queue_.mustWaitFor(kSession, 500));
}

TEST_F(DecisionQueueTest, AppliesInTheOrderOfTheBlocks) {
  EXPECT_TRUE(applied(1).empty());
  queue_.add({kSession, 500000, 3});  // far ahead: it must not hold up what comes after it
  queue_.add({kSession, 300, 2});
  queue_.add({kSession, 200, 1});
  EXPECT_EQ(applied(200), std::vector<int>{1});
  EXPECT_EQ(applied(300), std::vector<int>{2});
}

TEST_F(DecisionQueueTest, HoldsABoundedNumber) {
  EXPECT_TRUE(applied(1).empty());
  for (std::uint64_t i = 0; i < 1000; ++i) queue_.add({kSession, 1000 + i, 2});
  queue_.add({kSession, 200, 1});
  EXPECT_EQ(queue_.counts().early, 1001 - DecisionQueue<Decision>::kMostWaiting);
  EXPECT_EQ(applied(200), std::vector<int>{1});
}

}  // namespace
}  // namespace cvg
