#include "ring_gyro/signals/pair_merge.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace cvg {
namespace {

constexpr std::int64_t kBlock = 1000000;

template <typename Signal>
Signal at(std::uint64_t sequence, std::uint32_t session = 1) {
  Signal signal;
  signal.stamp = {session, sequence, static_cast<std::int64_t>(sequence + 1) * kBlock, kBlock};
  return signal;
}
OrbitalElements elements(std::uint64_t sequence, std::uint32_t session = 1) {
  return at<OrbitalElements>(sequence, session);
}
ControlGains gains(std::uint64_t sequence, std::uint32_t session = 1) {
  return at<ControlGains>(sequence, session);
}

class PairMergeTest : public ::testing::Test {
 protected:
  std::vector<std::uint64_t> sequences_;
  PairMerge merge_{[this](const OrbitalElements& e, const ControlGains& g) {
    EXPECT_EQ(e.stamp.sequence, g.stamp.sequence);
    EXPECT_EQ(e.stamp.session, g.stamp.session);
    sequences_.push_back(e.stamp.sequence);
  }};
  using Sequences = std::vector<std::uint64_t>;
};

TEST_F(PairMergeTest, PairsWhateverTheInterleaving) {
  for (std::uint64_t i = 0; i < 3; ++i) merge_.add(elements(i));
  EXPECT_TRUE(sequences_.empty());
  for (std::uint64_t i = 0; i < 5; ++i) merge_.add(gains(i));
  EXPECT_EQ(sequences_, (Sequences{0, 1, 2}));
  for (std::uint64_t i = 3; i < 5; ++i) merge_.add(elements(i));
  EXPECT_EQ(sequences_, (Sequences{0, 1, 2, 3, 4}));
  EXPECT_EQ(merge_.counts().pairs, 5u);
}

TEST_F(PairMergeTest, DropsWhatHasLostItsPartner) {
  merge_.add(elements(0));
  merge_.add(elements(1));
  merge_.add(elements(2));
  merge_.add(gains(2));
  merge_.add(gains(3));
  merge_.add(elements(4));
  merge_.add(gains(4));
  EXPECT_EQ(sequences_, (Sequences{2, 4}));
  EXPECT_EQ(merge_.counts().elements_alone, 2u);
  EXPECT_EQ(merge_.counts().gains_alone, 1u);
  EXPECT_EQ(merge_.elementsCounts().lost, 1u);
  EXPECT_EQ(merge_.gainsCounts().lost, 0u);
}

TEST_F(PairMergeTest, LeavesOutDuplicatesAndZeroStamps) {
  merge_.add(elements(0));
  merge_.add(elements(0));
  merge_.add(gains(0));
  merge_.add(gains(0));
  OrbitalElements unstamped = elements(1);
  unstamped.stamp.end_ns = 0;
  merge_.add(unstamped);
  merge_.add(elements(1));
  merge_.add(gains(1));
  EXPECT_EQ(sequences_, (Sequences{0, 1}));
  EXPECT_EQ(merge_.elementsCounts().duplicates, 1u);
  EXPECT_EQ(merge_.gainsCounts().duplicates, 1u);
  EXPECT_EQ(merge_.elementsCounts().zero_stamps, 1u);
}

TEST_F(PairMergeTest, FollowsABagThatLoops) {
  // The elements are a loop ahead when the gains of the first are still coming.
  for (std::uint64_t i = 0; i < 4; ++i) merge_.add(elements(i));
  for (std::uint64_t i = 0; i < 2; ++i) merge_.add(elements(i));
  for (std::uint64_t i = 0; i < 4; ++i) merge_.add(gains(i));
  for (std::uint64_t i = 0; i < 2; ++i) merge_.add(gains(i));
  EXPECT_EQ(sequences_, (Sequences{0, 1, 2, 3, 0, 1}));
  EXPECT_EQ(merge_.elementsCounts().steps_back, 1u);
  EXPECT_EQ(merge_.gainsCounts().steps_back, 1u);
  EXPECT_EQ(merge_.counts().elements_alone + merge_.counts().gains_alone, 0u);
}

TEST_F(PairMergeTest, FollowsANewSession) {
  merge_.add(elements(7, 1));
  merge_.add(elements(0, 2));
  merge_.add(elements(1, 2));
  merge_.add(gains(6, 1));
  merge_.add(gains(7, 1));
  merge_.add(gains(0, 2));
  merge_.add(gains(1, 2));
  EXPECT_EQ(sequences_, (Sequences{7, 0, 1}));
  EXPECT_EQ(merge_.counts().gains_alone, 1u);
  EXPECT_EQ(merge_.elementsCounts().new_sessions, 1u);
}

TEST_F(PairMergeTest, RecoversWhenOneTopicLostAWholeSession) {
  merge_.add(elements(0, 1));
  merge_.add(gains(0, 1));
  merge_.add(elements(0, 2));  // its gains never come
  merge_.add(elements(0, 3));
  merge_.add(gains(0, 3));
  merge_.add(elements(1, 3));  // its gains never come either
  merge_.add(gains(2, 3));
  merge_.add(elements(2, 3));
  merge_.add(elements(0, 4));
  merge_.add(gains(0, 4));
  EXPECT_EQ(sequences_, (Sequences{0, 0, 2, 0}));
  EXPECT_EQ(merge_.counts().elements_alone, 2u);
  EXPECT_EQ(merge_.counts().gains_alone, 0u);
}

TEST_F(PairMergeTest, FlushCountsWhatWaits) {
  merge_.add(elements(0));
  merge_.add(elements(1));
  merge_.flush();
  EXPECT_EQ(merge_.counts().elements_alone, 2u);
  EXPECT_TRUE(sequences_.empty());
  merge_.add(elements(2));
  merge_.add(gains(2));
  EXPECT_EQ(sequences_, (Sequences{2}));
}

TEST_F(PairMergeTest, ASilentTopicIsNotWaitedForForEver) {
  const std::uint64_t most = PairMerge::kMostWaiting;
  for (std::uint64_t i = 0; i < most; ++i) merge_.add(elements(i));
  EXPECT_EQ(merge_.waiting(), most);
  EXPECT_EQ(merge_.counts().elements_alone, 0u);
  for (std::uint64_t i = most; i < most + 1000; ++i) merge_.add(elements(i));
  EXPECT_EQ(merge_.waiting(), most);
  EXPECT_EQ(merge_.counts().elements_alone, 1000u);
  EXPECT_EQ(merge_.counts().overdue, 1000u);
  // The gains come after all: from the oldest that waits on nothing is lost.
  for (std::uint64_t i = 990; i < most + 1000; ++i) merge_.add(gains(i));
  EXPECT_EQ(merge_.counts().pairs, most);
  EXPECT_EQ(sequences_.front(), 1000u);
  EXPECT_EQ(merge_.counts().gains_alone, 10u);
  EXPECT_EQ(merge_.waiting(), 0u);
  for (std::uint64_t i = 0; i < 2 * most; ++i) merge_.add(gains(most + 1000 + i));
  EXPECT_EQ(merge_.waiting(), most);
  EXPECT_EQ(merge_.counts().overdue, 1000u + most);
}

TEST_F(PairMergeTest, TopicsInDifferentSessionsAreBoundedToo) {
  const std::uint64_t most = PairMerge::kMostWaiting;
  for (std::uint64_t i = 0; i < 2 * most; ++i) {
    merge_.add(elements(i, 1));
    merge_.add(gains(i, 2));
  }
  EXPECT_EQ(merge_.waiting(), 2 * most);
  EXPECT_EQ(merge_.counts().overdue, 2 * most);
  EXPECT_TRUE(sequences_.empty());
}

TEST_F(PairMergeTest, WhatGoesOnInASessionThatWasLeftIsLeftOut) {
  const auto add = [this](std::uint64_t sequence, std::uint32_t session) {
    merge_.add(elements(sequence, session));
    merge_.add(gains(sequence, session));
  };
  add(10, 1);
  add(0, 2);  // another plant starts, the first one goes on
  add(11, 1);
  add(1, 2);
  add(12, 1);
  add(2, 2);
  EXPECT_EQ(sequences_, (Sequences{10, 0, 1, 2}));
  EXPECT_EQ(merge_.elementsCounts().left_sessions, 2u);
  EXPECT_EQ(merge_.elementsCounts().new_sessions, 1u);
  add(10, 1);  // a bag that loops begins again
  add(0, 3);
  add(9, 1);
  EXPECT_EQ(merge_.elementsCounts().left_sessions, 3u);
  EXPECT_EQ(sequences_, (Sequences{10, 0, 1, 2, 0, 9}));
}

TEST(PairMerge, MayBeFlushedFromItsSink) {
  int pairs = 0;
  PairMerge* self = nullptr;
  PairMerge merge([&](const OrbitalElements&, const ControlGains&) {
    ++pairs;
    self->flush();
  });
  self = &merge;
  merge.add(elements(0));
  merge.add(elements(1));
  merge.add(gains(0));
  EXPECT_EQ(pairs, 1);
  EXPECT_EQ(merge.counts().elements_alone, 1u);
}

TEST(TimeGuard, SortsStamps) {
  TimeGuard guard;
  BlockStamp stamp{1, 5, 100, 10};
  EXPECT_EQ(guard.check(stamp), StampOrder::kFirst);
  EXPECT_EQ(guard.check(stamp), StampOrder::kDuplicate);
  EXPECT_EQ(guard.check({1, 6, 110, 10}), StampOrder::kNext);
  EXPECT_EQ(guard.check({1, 9, 140, 10}), StampOrder::kGap);
  EXPECT_EQ(guard.check({1, 10, 0, 10}), StampOrder::kZero);
  EXPECT_EQ(guard.check({1, 10, 150, 10}), StampOrder::kNext);
  EXPECT_EQ(guard.check({1, 11, 120, 10}), StampOrder::kStepBack);
  EXPECT_EQ(guard.check({1, 2, 70, 10}), StampOrder::kStepBack);
  EXPECT_EQ(guard.check({2, 0, 50, 10}), StampOrder::kNewSession);
  EXPECT_EQ(guard.counts().lost, 2u);
  EXPECT_EQ(guard.counts().accepted, 7u);
  EXPECT_EQ(guard.counts().steps_back, 2u);
}

}  // namespace
}  // namespace cvg
