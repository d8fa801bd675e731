// A bag is read in the order that rosbag::View gives, whatever its order in the file, and each
// chunk is decompressed once.

#include "ring_gyro/ros/chunk_merge.h"

#include <gtest/gtest.h>
#include <std_msgs/UInt32MultiArray.h>

#include <algorithm>
#include <random>

#include "ros/bag_fixture.h"

namespace ring_gyro::test {
namespace {

using rosbag::compression::CompressionType;

struct Written {
  std::string topic;
  std::string publisher;
  ros::Time time;
  std::uint32_t number = 0;
};

/// What came of a bag: the numbers of the messages, in order.
using Numbers = std::vector<std::uint32_t>;

/// Many with equal times, on three topics with two publishers each.
std::vector<Written> randomMessages(std::uint32_t count, std::mt19937& random) {
  std::vector<Written> messages;
  std::uniform_int_distribution<int> topic(0, 29);
  std::uniform_int_distribution<std::uint32_t> time(1, count / 4);
  for (std::uint32_t i = 0; i < count; ++i) {
    const int which = topic(random);
    messages.push_back({"/topic_" + std::to_string(which % 3), "/node_" + std::to_string(which % 2),
                        ros::Time(100, time(random)), i});
  }
  return messages;
}

enum class Order { kByTime, kBursts, kByTopic, kBackwards, kRandom, kTwice, kOneStray };

std::vector<Written> ordered(std::vector<Written> messages, Order order, std::mt19937& random) {
  const auto by_time = [](const Written& a, const Written& b) { return a.time < b.time; };
  const auto by_topic = [](const Written& a, const Written& b) { return a.topic < b.topic; };
  if (order == Order::kRandom) {
    std::shuffle(messages.begin(), messages.end(), random);
    return messages;
  }
  std::stable_sort(messages.begin(), messages.end(), by_time);
  if (order == Order::kBursts) {
    for (std::size_t i = 0; i < messages.size(); i += 300) {
      std::stable_sort(messages.begin() + static_cast<long>(i),
                       messages.begin() + static_cast<long>(std::min(i + 300, messages.size())),
                       by_topic);
    }
  }
  if (order == Order::kByTopic) std::stable_sort(messages.begin(), messages.end(), by_topic);
  if (order == Order::kBackwards) std::reverse(messages.begin(), messages.end());
  if (order == Order::kTwice) {  // two recorders' bags, one after the other
    const std::vector<Written> first = messages;
    messages.insert(messages.end(), first.begin(), first.end());
  }
  if (order == Order::kOneStray) std::swap(messages.front(), messages.back());
  return messages;
}

void write(const std::vector<Written>& messages, const std::string& path,
           CompressionType compression) {
  const std::size_t parts = 2;  // the second is appended, as by another recorder
  for (std::size_t part = 0; part < parts; ++part) {
    rosbag::Bag bag(path, part == 0 ? rosbag::bagmode::Write : rosbag::bagmode::Append);
    bag.setCompression(compression);
    bag.setChunkThreshold(4096);
    for (std::size_t i = part * messages.size() / parts; i < (part + 1) * messages.size() / parts;
         ++i) {
      const Written& written = messages[i];
      std_msgs::UInt32MultiArray message;
      message.data.assign(1 + written.number % 7, written.number);
      const auto header = boost::make_shared<ros::M_string>();
      (*header)["type"] = ros::message_traits::datatype(message);
      (*header)["md5sum"] = ros::message_traits::md5sum(message);
      (*header)["message_definition"] = ros::message_traits::definition(message);
      (*header)["callerid"] = written.publisher;
      bag.write(written.topic, written.time, message, header);
    }
    bag.close();
  }
}

std::uint32_t numberOf(const std::uint8_t* bytes) {
  std_msgs::UInt32MultiArray message;
  ros::serialization::IStream stream(const_cast<std::uint8_t*>(bytes), 1u << 16);
  ros::serialization::deserialize(stream, message);
  return message.data.at(0);
}

Numbers readByView(const std::string& path, const std::vector<std::string>& topics,
                   const ros::Time& from, const ros::Time& to) {
  const rosbag::Bag bag(path);
  rosbag::View view(bag, rosbag::TopicQuery(topics), from, to);
  Numbers numbers;
  for (const rosbag::MessageInstance& instance : view) {
    numbers.push_back(instance.instantiate<std_msgs::UInt32MultiArray>()->data.at(0));
  }
  return numbers;
}

struct Merged {
  Numbers numbers;
  bridge::ChunkMerge::Outcome outcome;
};

Merged readByMerge(const std::string& path, const bridge::BagContents& contents,
                   const std::vector<std::string>& topics, const ros::Time& from,
                   const ros::Time& to, std::size_t most_held = bridge::ChunkMerge::kMostHeld) {
  Merged merged;
  bridge::BagSinks sinks;
  for (const bridge::BagConnection& connection : contents.connections) {
    if (std::count(topics.begin(), topics.end(), connection.topic) == 0) continue;
    sinks[connection.id] = [&merged](const bridge::BagMessage& message) {
      merged.numbers.push_back(numberOf(message.bytes));
    };
  }
  merged.outcome = bridge::ChunkMerge(path, contents, sinks, from, to, most_held).run();
  return merged;
}

class ChunkMergeTest : public testing::TestWithParam<std::tuple<Order, CompressionType>> {
 protected:
  ChunkMergeTest() {
    write(ordered(randomMessages(3000, random_), std::get<0>(GetParam()), random_), bag_,
          std::get<1>(GetParam()));
  }

  std::mt19937 random_{7};
  TemporaryFolder folder_;
  std::string bag_ = folder_.file("run.bag");
  const std::vector<std::string> all_ = {"/topic_0", "/topic_1", "/topic_2"};
};

TEST_P(ChunkMergeTest, GivesTheOrderOfViewAndOpensEachChunkOnce) {
  const bridge::BagContents contents = bridge::contentsByIndex(bag_);
  EXPECT_GE(contents.connections.size(), 6u);
  EXPECT_GT(contents.chunks.size(), 20u);
  const Merged merged = readByMerge(bag_, contents, all_, ros::TIME_MIN, ros::TIME_MAX);
  EXPECT_EQ(merged.numbers, readByView(bag_, all_, ros::TIME_MIN, ros::TIME_MAX));
  EXPECT_EQ(merged.numbers.size(), contents.messages());
  EXPECT_EQ(merged.outcome.chunks_opened, contents.chunks.size());
  EXPECT_EQ(merged.outcome.loss.bytes, 0u);
}

TEST_P(ChunkMergeTest, GivesAPartOfTheTimeAndOfTheTopics) {
  const bridge::BagContents contents = bridge::contentsByIndex(bag_);
  const std::vector<std::string> some = {"/topic_1", "/topic_2"};
  const ros::Time from(100, 300);
  const ros::Time to(100, 500);
  const Numbers expected = readByView(bag_, some, from, to);
  ASSERT_GT(expected.size(), 100u);
  const Merged merged = readByMerge(bag_, contents, some, from, to);
  EXPECT_EQ(merged.numbers, expected);
  EXPECT_LE(merged.outcome.chunks_opened, contents.chunks.size());
}

TEST_P(ChunkMergeTest, HoldsNoMoreThanItMay) {
  const bridge::BagContents contents = bridge::contentsByIndex(bag_);
  constexpr std::size_t kMostHeld = 30'000;  // the whole is some 170 kB
  const Merged merged = readByMerge(bag_, contents, all_, ros::TIME_MIN, ros::TIME_MAX, kMostHeld);
  EXPECT_EQ(merged.numbers,
            readByMerge(bag_, contents, all_, ros::TIME_MIN, ros::TIME_MAX).numbers);
  EXPECT_LE(merged.outcome.chunks_opened, 12 * contents.chunks.size());
}

TEST_P(ChunkMergeTest, IsTheSameWithoutTheIndex) {
  const Merged merged =
      readByMerge(bag_, bridge::contentsByIndex(bag_), all_, ros::TIME_MIN, ros::TIME_MAX);
  const bridge::BagScan scan = bridge::contentsByScan(bag_);
  EXPECT_EQ(scan.loss.bytes, 0u);
  EXPECT_EQ(readByMerge(bag_, scan.contents, all_, ros::TIME_MIN, ros::TIME_MAX).numbers,
            merged.numbers);
}

TEST_P(ChunkMergeTest, PassesOverAChunkThatIsDamaged) {
  const bridge::BagContents contents = bridge::contentsByIndex(bag_);
  const bridge::BagChunk& chunk = contents.chunks[contents.chunks.size() / 2];
  std::string bytes = contentsOf(bag_);
  bytes.replace(chunk.position, 16, 16, '\xff');
  writeContents(bag_, bytes);
  const Merged merged = readByMerge(bag_, contents, all_, ros::TIME_MIN, ros::TIME_MAX);
  std::uint64_t lost = 0;
  for (const bridge::ChunkShare& share : chunk.shares) lost += share.messages;
  EXPECT_EQ(merged.numbers.size(), contents.messages() - lost);
  EXPECT_EQ(merged.outcome.chunks_opened, contents.chunks.size() - 1);
  EXPECT_EQ(merged.outcome.loss.first, chunk.position);
  EXPECT_GT(merged.outcome.loss.bytes, 0u);
}

INSTANTIATE_TEST_SUITE_P(Orders, ChunkMergeTest,
                         testing::Combine(testing::Values(Order::kByTime, Order::kBursts,
                                                          Order::kByTopic, Order::kBackwards,
                                                          Order::kRandom, Order::kTwice,
                                                          Order::kOneStray),
                                          testing::Values(rosbag::compression::LZ4)));
INSTANTIATE_TEST_SUITE_P(Compressions, ChunkMergeTest,
                         testing::Combine(testing::Values(Order::kBursts),
                                          testing::Values(rosbag::compression::Uncompressed,
                                                          rosbag::compression::BZ2)));

}  // namespace
}  // namespace ring_gyro::test
