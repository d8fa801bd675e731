// What the tools make of a bag does not depend on the order of the messages in it, to the last
// byte.

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <memory>
#include <regex>
#include <set>

#include "ring_gyro/ros/chunk_merge.h"
#include "ros/bag_fixture.h"

namespace ring_gyro::test {
namespace {

/// A tool, run in a folder with run.bag in it, and the files that it writes there besides.
struct Command {
  std::string line;
  std::vector<std::string> files;
};

class BagOrderTest : public testing::TestWithParam<std::tuple<BagOrder, rosbag::CompressionType>> {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    recordRun(cvg::readConfigurationFile(configuration(),
                                         {"run/duration=3.05", "control/virtual_rate=1.0"}),
              straight());
    for (const Command& command : commands()) expected_.push_back(run(command, folder_->file("")));
  }
  static void TearDownTestSuite() {
    folder_.reset();
    expected_.clear();
  }

  static std::string configuration() {
    return std::string(RING_GYRO_CONFIG_DIR) + "/paper_simulation.yaml";
  }
  static std::string straight() { return folder_->file("run.bag"); }
  static std::vector<Command> commands() {
    const std::string with = " --config " + configuration();
    return {{"identify run.bag --extended --json run.json" + with, {"run.json"}},
            {"identify run.bag --start 1.2 --duration 1.1 --json part.json" + with, {"part.json"}},
            {"validate_bag run.bag", {}},
            {"compare_identifiers run.bag" + with, {}},
            {"export_csv run.bag --output run.csv", {"run.csv"}},
            {"summarise_run run.bag --json summary.json --csv series",
             {"summary.json", "series/loops.csv", "series/ring_up.csv", "series/gains.csv",
              "series/estimates.csv", "series/rates.csv", "series/allan.csv"}}};
  }

  /// All that a tool writes, without the times that it took.
  static std::string run(const Command& command, const std::string& folder) {
    const int status = std::system(
        ("cd '" + folder + "' && " + RING_GYRO_NODE_DIR + "/" + command.line + " >stdout 2>stderr")
            .c_str());
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0)
        << command.line << ": " << contentsOf(folder + "/stderr");
    std::string all = contentsOf(folder + "/stdout") + contentsOf(folder + "/stderr");
    for (const std::string& file : command.files) {
      EXPECT_TRUE(exists(folder + "/" + file)) << file;
      all += contentsOf(folder + "/" + file);
    }
    return std::regex_replace(all, std::regex("\\| +[0-9.]+\n"), "|\n");
  }

  static std::unique_ptr<TemporaryFolder> folder_;
  static std::vector<std::string> expected_;
};

std::unique_ptr<TemporaryFolder> BagOrderTest::folder_;
std::vector<std::string> BagOrderTest::expected_;

TEST_P(BagOrderTest, ToolsGiveTheSameBytes) {
  const TemporaryFolder folder;
  reorderBag(straight(), folder.file("run.bag"), std::get<0>(GetParam()), std::get<1>(GetParam()));
  for (std::size_t i = 0; i < commands().size(); ++i) {
    EXPECT_EQ(run(commands()[i], folder.file("")), expected_[i]) << commands()[i].line;
  }
}

TEST_P(BagOrderTest, EachChunkIsDecompressedOnce) {
  const TemporaryFolder folder;
  const std::string bag = folder.file("run.bag");
  reorderBag(straight(), bag, std::get<0>(GetParam()), std::get<1>(GetParam()));
  const bridge::BagContents contents = bridge::contentsByIndex(bag);
  std::uint64_t messages = 0;
  bridge::BagSinks sinks;
  for (const bridge::BagConnection& connection : contents.connections) {
    sinks[connection.id] = [&messages](const bridge::BagMessage&) { ++messages; };
  }
  const auto outcome = bridge::ChunkMerge(bag, contents, sinks, ros::TIME_MIN, ros::TIME_MAX).run();
  EXPECT_EQ(messages, contents.messages());
  EXPECT_GT(contents.chunks.size(), 30u);
  EXPECT_EQ(outcome.chunks_opened, contents.chunks.size());
}

INSTANTIATE_TEST_SUITE_P(
    Orders, BagOrderTest,
    testing::Values(std::make_tuple(BagOrder::kBursts, rosbag::compression::LZ4),
                    std::make_tuple(BagOrder::kBursts, rosbag::compression::BZ2),
                    std::make_tuple(BagOrder::kBursts, rosbag::compression::Uncompressed),
                    std::make_tuple(BagOrder::kByTopic, rosbag::compression::LZ4),
                    std::make_tuple(BagOrder::kBackwards, rosbag::compression::BZ2),
                    std::make_tuple(BagOrder::kHalves, rosbag::compression::Uncompressed),
                    std::make_tuple(BagOrder::kStray, rosbag::compression::LZ4)));

}  // namespace
}  // namespace ring_gyro::test
