// Messages go on in the order of their stamps, however their topics arrive, and wait no longer than
// they may.

#include "ring_gyro/ros/stamp_merge.h"

#include <gtest/gtest.h>

#include <memory>
#include <ostream>
#include <random>
#include <vector>

namespace ring_gyro::test {
namespace {

constexpr std::int64_t kBlock = 1'000'000;
constexpr std::size_t kBytes = 100;
constexpr std::int64_t kPeriod = 10;  // blocks

struct Message {
  std::size_t topic;
  std::int64_t block;
  std::uint32_t session = 1;
  bool operator==(const Message& other) const {
    return topic == other.topic && block == other.block && session == other.session;
  }
};
using Messages = std::vector<Message>;

std::ostream& operator<<(std::ostream& out, const Message& message) {
  return out << message.session << ":" << message.topic << "@" << message.block;
}

/// Two topics that send each block, one that sends each period, one that ends the run.
class StampMergeTest : public testing::Test {
 protected:
  static constexpr std::size_t kFirst = 0, kPeriodic = 1, kEnd = 2, kSecond = 3;

  void start(const bridge::StampMerge::Limits& limits) {
    merge_ = std::make_unique<bridge::StampMerge>(limits);
    const auto published = [this] { return published_; };
    for (const bridge::StampMerge::Topic& topic :
         {bridge::StampMerge::Topic{true, 0, [] { return true; }},
          bridge::StampMerge::Topic{true, (kPeriod - 1) * kBlock, published},
          bridge::StampMerge::Topic{false, 0, [] { return true; }},
          bridge::StampMerge::Topic{true, 0, [] { return true; }}}) {
      merge_->addTopic(topic);
    }
  }
  void add(const Message& message) {
    merge_->add(message.topic, message.session, (message.block + 1) * kBlock, kBytes,
                [this, message] { written_.push_back(message); });
  }
  static Messages run(std::int64_t blocks, std::uint32_t session = 1) {
    Messages messages;
    for (std::int64_t block = 0; block < blocks; ++block) {
      messages.push_back({kFirst, block, session});
      if ((block + 1) % kPeriod == 0) messages.push_back({kPeriodic, block, session});
      messages.push_back({kSecond, block, session});
    }
    messages.push_back({kEnd, blocks - 1, session});
    return messages;
  }
  /// Each topic in order, but their bursts as they come.
  static Messages inBursts(const Messages& messages, std::mt19937& random) {
    std::vector<Messages> topics(4);
    for (const Message& message : messages) topics[message.topic].push_back(message);
    std::vector<std::size_t> next(4, 0);
    Messages bursts;
    while (bursts.size() < messages.size()) {
      const std::size_t topic = random() % 4;
      for (std::size_t i = random() % 200; i > 0 && next[topic] < topics[topic].size(); --i) {
        bursts.push_back(topics[topic][next[topic]++]);
      }
    }
    return bursts;
  }

  bool published_ = true;
  Messages written_;
  std::unique_ptr<bridge::StampMerge> merge_;
};

TEST_F(StampMergeTest, GivesTheOrderOfStampsHoweverTopicsArrive) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 20; ++trial) {
    written_.clear();
    start({1u << 30});
    for (const Message& message : inBursts(run(1000), random)) add(message);
    merge_->flush();
    EXPECT_EQ(written_, run(1000));
    EXPECT_EQ(merge_->late(), 0u);
  }
}

TEST_F(StampMergeTest, WaitsForNothingThatCannotCome) {
  start({1u << 30});
  add({kFirst, 9});
  add({kSecond, 9});
  EXPECT_TRUE(written_.empty());  // the periodic one is missing yet
  add({kPeriodic, 9});
  EXPECT_EQ(written_.size(), 3u);
  for (std::int64_t block = 10; block < 18; ++block) {
    add({kFirst, block});
    add({kSecond, block});
  }
  EXPECT_EQ(written_.size(), 19u);  // it cannot send before the period is over
  add({kFirst, 19});
  add({kSecond, 19});
  EXPECT_EQ(written_.size(), 19u);
  published_ = false;  // its node has gone
  add({kFirst, 20});
  EXPECT_EQ(written_.size(), 21u);
  EXPECT_EQ(merge_->late(), 0u);
}

TEST_F(StampMergeTest, SilentTopicDelaysNoMoreThanTheLimit) {
  start({50 * kBytes});
  for (std::int64_t block = 0; block < 1000; ++block) {
    add({kFirst, block});
    add({kSecond, block});
    EXPECT_GE(written_.size() + 50, static_cast<std::size_t>(2 * (block + 1)));
  }
  EXPECT_EQ(merge_->late(), 0u);
  // What it sends after all is written, and counted where the others have gone on without it.
  add({kPeriodic, 9});
  add({kPeriodic, 999});
  merge_->flush();
  EXPECT_EQ(merge_->late(), 1u);
  EXPECT_EQ(written_.size(), 2002u);
  for (std::size_t i = 1; i < written_.size(); ++i) {
    if (written_[i].topic != kPeriodic && written_[i - 1].topic != kPeriodic) {
      EXPECT_LE(written_[i - 1].block, written_[i].block);
    }
  }
}

TEST_F(StampMergeTest, SilentTopicDelaysNoLongerThanTheSpan) {
  start({1u << 30, 100 * kBlock});
  for (std::int64_t block = 0; block < 1000; ++block) {
    add({kFirst, block});
    add({kSecond, block});
    EXPECT_GE(written_.size() + 202, static_cast<std::size_t>(2 * (block + 1)));
  }
}

TEST_F(StampMergeTest, NewSessionComesAfterTheOld) {
  std::mt19937 random(4);
  Messages both = run(300, 7);
  const Messages second = run(500, 2);
  both.insert(both.end(), second.begin(), second.end());
  start({1u << 30});
  for (const Message& message : inBursts(both, random)) add(message);
  merge_->flush();
  EXPECT_EQ(written_, both);
  EXPECT_EQ(merge_->late(), 0u);
}

TEST_F(StampMergeTest, OneStampThatStepsBackHoldsNothingUp) {
  start({1u << 30});
  published_ = false;
  add({kFirst, 0});
  add({kFirst, 1});
  add({kSecond, 0});
  add({kSecond, -1});  // a stamp of zero
  add({kSecond, 2});
  add({kFirst, 2});
  EXPECT_EQ(written_.size(), 6u);
  EXPECT_EQ(merge_->late(), 1u);
}

}  // namespace
}  // namespace ring_gyro::test
