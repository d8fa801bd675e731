#include "ring_gyro/ros/bag_writer.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <thread>

#include "ring_gyro/ros/loop_bag.h"
#include "ring_gyro/ros/run_ends.h"
#include "ring_gyro/ros/topics.h"

namespace ring_gyro::test {
namespace {

namespace fs = std::filesystem;

class BagWriterTest : public ::testing::Test {
 protected:
  BagWriterTest() { fs::create_directory(folder_); }
  ~BagWriterTest() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// Numbers that cannot be compressed, so that the file grows with the messages.
  static void writeBlocks(bridge::BagWriter& writer, std::uint64_t count) {
    ring_gyro::OrbitalElements elements;
    ring_gyro::ControlGains gains;
    std::uint64_t state = 1;
    const auto number = [&state] {
      state = state * 6364136223846793005u + 1442695040888963407u;
      return static_cast<double>(state >> 11);
    };
    for (std::uint64_t block = 0; block < count; ++block) {
      elements.header.stamp = gains.header.stamp =
          ros::Time(1 + block / 1000, block % 1000 * 1000000);
      elements.sequence = gains.sequence = block;
      elements.a = number(), elements.b = number(), elements.theta = number();
      elements.phi = number(), gains.beta = number(), gains.alpha = number();
      writer.write(bridge::topics::kOrbitalElements, elements);
      writer.write(bridge::topics::kControlGains, gains);
    }
  }

  /// The one file with this end to its name; empty when there is not exactly one.
  std::string only(const std::string& suffix) const {
    std::string found;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      const std::string name = entry.path().string();
      if (name.size() < suffix.size() ||
          name.compare(name.size() - suffix.size(), suffix.size(), suffix) != 0) {
        continue;
      }
      if (!found.empty()) return "";
      found = name;
    }
    return found;
  }

  static std::uint64_t blocksIn(const std::string& bag) {
    std::uint64_t blocks = 0;
    bridge::LoopBag(bag).read([&](const auto&, const ros::Time&) { ++blocks; },
                              [](const auto&, const ros::Time&) {});
    return blocks;
  }

  static std::string faultOf(const std::function<void()>& action) {
    try {
      action();
      return "";
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  }

 private:
  fs::path folder_ =
      fs::temp_directory_path() / ("ring_gyro_bag_writer_" + std::to_string(getpid()));
};

/// No file of this process grows beyond this while it is there.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  void (*handler_)(int);
  rlimit before_ = {};
};

TEST_F(BagWriterTest, IsThereWhenItIsFinished) {
  bridge::BagWriter writer(path("x.bag"));
  writeBlocks(writer, 10);
  EXPECT_FALSE(fs::exists(path("x.bag")));
  EXPECT_NE(only(".active"), "");
  writer.finish();
  EXPECT_EQ(blocksIn(path("x.bag")), 10u);
  EXPECT_EQ(only(".active"), "");
}

TEST_F(BagWriterTest, KeepsWhatWasWrittenUntilItWasCut) {
  {
    bridge::BagWriter writer(path("x.bag"));
    writeBlocks(writer, 10);
  }
  EXPECT_FALSE(fs::exists(path("x.bag")));
  EXPECT_EQ(blocksIn(only(".active")), 10u);
  {
    bridge::BagWriter writer(path("y.bag"));
    writeBlocks(writer, 10);
    writer.discard();
  }
  { const bridge::BagWriter writer(path("z.bag")); }
  EXPECT_EQ(std::distance(fs::directory_iterator(path("")), {}), 1);
}

// rosbag throws again from its destructor, which ends the program.
TEST_F(BagWriterTest, OutlivesADiskThatIsFull) {
  {
    bridge::BagWriter writer(path("x.bag"));
    {
      const FileSizeLimit limit(2000000);
      const std::string fault = faultOf([&] { writeBlocks(writer, 1000000); });
      EXPECT_EQ(fault.rfind(path("x.bag") + ": cannot be written: File too large; raise", 0), 0u)
          << fault;
      EXPECT_NE(fault.find("; what came before is in " + only(".active")), std::string::npos)
          << fault;
      EXPECT_EQ(faultOf([&] { writeBlocks(writer, 1); }), fault);
      EXPECT_EQ(faultOf([&] { writer.finish(); }), fault);
    }
  }
  EXPECT_FALSE(fs::exists(path("x.bag")));
  EXPECT_GT(blocksIn(only(".active")), 1000u);
}

TEST_F(BagWriterTest, SaysThatADiskIsFullOnlyAtTheEnd) {
  bridge::BagWriter writer(path("x.bag"));
  writeBlocks(writer, 1000);  // all still in memory
  const FileSizeLimit limit(5000);
  EXPECT_NE(faultOf([&] { writer.finish(); }).find("File too large"), std::string::npos);
  EXPECT_FALSE(fs::exists(path("x.bag")));
}

TEST_F(BagWriterTest, DiscardsAfterAFaultToo) {
  bridge::BagWriter writer(path("x.bag"));
  const FileSizeLimit limit(100000);
  EXPECT_NE(faultOf([&] { writeBlocks(writer, 1000000); }), "");
  writer.discard();
  EXPECT_TRUE(fs::is_empty(path("")));
}

TEST_F(BagWriterTest, GivesAPipeTheWholeBag) {
  ASSERT_EQ(mkfifo(path("pipe").c_str(), 0600), 0);
  std::thread reader([this] {
    std::ifstream from(path("pipe"), std::ios::binary);
    std::ofstream(path("copy.bag"), std::ios::binary) << from.rdbuf();
  });
  bridge::BagWriter writer(path("pipe"));
  writeBlocks(writer, 5000);
  writer.finish();
  reader.join();
  EXPECT_TRUE(fs::is_fifo(path("pipe")));
  EXPECT_EQ(blocksIn(path("copy.bag")), 5000u);
}

TEST_F(BagWriterTest, RefusesWhatHasNoStampAndIsWholeAllTheSame) {
  {
    bridge::BagWriter writer(path("x.bag"));
    writeBlocks(writer, 10);
    const std::string fault = faultOf([&] { writer.write("topic", ring_gyro::EndOfRun()); });
    EXPECT_NE(fault.find("a message on topic has no stamp"), std::string::npos) << fault;
  }
  EXPECT_EQ(blocksIn(only(".active")), 10u);
}

TEST_F(BagWriterTest, LeavesAReadableBagWhenItIsKilled) {
  const pid_t child = fork();
  if (child == 0) {
    bridge::BagWriter writer(path("x.bag"));
    writeBlocks(writer, 20000);
    kill(getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status));
  const std::string left = only(".active");
  EXPECT_EQ(fs::path(left).filename().string().rfind("x.bag.", 0), 0u);
  EXPECT_GT(blocksIn(left), 1000u);
  bridge::BagFile killed(left);
  bridge::RunEnds ends;
  bridge::BagSinks sinks;
  bridge::addRunEnds(killed, ends, sinks);
  killed.read(sinks);
  EXPECT_TRUE(ends.empty());
  bridge::BagWriter next(path("x.bag"));
  writeBlocks(next, 10);
  next.finish();
  EXPECT_EQ(blocksIn(path("x.bag")), 10u);
  EXPECT_EQ(only(".active"), left);
}

}  // namespace
}  // namespace ring_gyro::test
