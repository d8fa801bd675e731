#include "ring_gyro/common/staged_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace cvg {
namespace {

namespace fs = std::filesystem;

class StagedFileTest : public ::testing::Test {
 protected:
  StagedFileTest() {
    std::string name = (fs::temp_directory_path() / "ring_gyro_XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~StagedFileTest() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  static std::string textOf(const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }

  fs::path folder_;
};

TEST_F(StagedFileTest, KeepsBesideWhatWasThereUntilItIsWhole) {
  std::ofstream(path("a")) << "of an earlier run";
  StagedFile file(path("a"));
  EXPECT_EQ(file.kept(), "");
  for (const std::string stage : {"one", "one and two"}) {
    file.keep(stage);
    EXPECT_EQ(file.kept(), path("a.partial"));
    EXPECT_EQ(textOf(file.kept()), stage);
    EXPECT_EQ(textOf(path("a")), "of an earlier run");
  }
  file.finish("whole");
  EXPECT_EQ(textOf(path("a")), "whole");
  EXPECT_EQ(file.kept(), "");
  EXPECT_FALSE(fs::exists(path("a.partial")));
}

TEST_F(StagedFileTest, ARunThatEndsEarlyLeavesWhatItKept) {
  { StagedFile(path("a")).keep("one"); }
  EXPECT_EQ(textOf(path("a.partial")), "one");
  EXPECT_FALSE(fs::exists(path("a")));
}

TEST_F(StagedFileTest, NothingIsKeptBesideAPipe) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  const int reader = ::open(path("pipe").c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  StagedFile file(path("pipe"));
  file.keep("one");
  EXPECT_EQ(file.kept(), "");
  EXPECT_FALSE(fs::exists(path("pipe.partial")));
  file.finish("whole");
  char text[8] = {};
  EXPECT_EQ(::read(reader, text, sizeof text), 5);
  EXPECT_STREQ(text, "whole");
  ::close(reader);
}

TEST_F(StagedFileTest, NobodyElseWritesItMeanwhile) {
  StagedFile file(path("a"));
  EXPECT_THROW(StagedFile(path("a")), std::runtime_error);
  EXPECT_THROW(writeWholeFile(path("a"), "other"), std::runtime_error);
  file.finish("whole");
  EXPECT_EQ(textOf(path("a")), "whole");
  writeWholeFile(path("a"), "other");
}

TEST_F(StagedFileTest, NoNameNoFile) {
  StagedFile file("");
  file.keep("one");
  file.finish("whole");
  EXPECT_EQ(file.kept(), "");
  EXPECT_FALSE(fs::exists(".partial"));
}

TEST_F(StagedFileTest, SaysAtOnceWhatCannotBeWritten) {
  EXPECT_THROW(StagedFile(path("absent") + "/a"), std::runtime_error);
}

}  // namespace
}  // namespace cvg
