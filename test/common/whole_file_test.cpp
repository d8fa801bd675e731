#include "ring_gyro/common/whole_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "ring_gyro/common/write_fault.h"

namespace cvg {
namespace {

namespace fs = std::filesystem;

class WholeFileTest : public ::testing::Test {
 protected:
  WholeFileTest() { fs::create_directory(folder_); }
  ~WholeFileTest() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  bool empty() const { return fs::is_empty(folder_); }

  static std::string contents(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  static std::string faultOf(const std::string& path) {
    try {
      requireWritable(path);
      return "";
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  }

 private:
  fs::path folder_ = fs::temp_directory_path() / ("ring_gyro_file_" + std::to_string(getpid()));
};

TEST_F(WholeFileTest, IsThereWhenItIsFinished) {
  WholeFile file(path("x.yaml"));
  file.write("one\n");
  file.write("two\n");
  EXPECT_FALSE(fs::exists(path("x.yaml")));
  file.finish();
  EXPECT_EQ(contents(path("x.yaml")), "one\ntwo\n");
  EXPECT_EQ(std::distance(fs::directory_iterator(path("")), {}), 1);
}

TEST_F(WholeFileTest, LeavesNothingAndChangesNothingWhenItIsNot) {
  { WholeFile(path("x.yaml")).write(std::string(100000, 'x')); }
  EXPECT_TRUE(empty());
  writeWholeFile(path("x.yaml"), "before");
  { WholeFile(path("x.yaml")).write("half"); }
  EXPECT_EQ(contents(path("x.yaml")), "before");
}

TEST_F(WholeFileTest, TryingLeavesNothing) {
  EXPECT_EQ(faultOf(path("x.yaml")), "");
  EXPECT_EQ(faultOf(""), "");
  EXPECT_TRUE(empty());
}

TEST_F(WholeFileTest, SaysWhichFolderIsMissing) {
  EXPECT_EQ(faultOf("/nonexistent/folder/x.yaml"),
            "/nonexistent/folder/x.yaml: cannot be written: No such file or directory; the folder "
            "/nonexistent/folder does not exist; make it or choose another place");
}

TEST_F(WholeFileTest, SaysThatAFolderIsNoFile) {
  fs::create_directory(path("folder"));
  EXPECT_EQ(faultOf(path("folder")),
            path("folder") + ": cannot be written: Is a directory; name a file in it");
}

TEST_F(WholeFileTest, WritesNothingThatWasNotAskedFor) {
  WholeFile file("");
  file.write("text");
  file.finish();
  EXPECT_TRUE(empty());
}

TEST(WriteFault, NamesAMendForEveryReason) {
  EXPECT_EQ(writeFault("/x/y", EACCES),
            "/x/y: cannot be written: Permission denied; choose a place that may be written to");
  EXPECT_EQ(writeFault("/x/y", ENOSPC),
            "/x/y: cannot be written: No space left on device; make room there, or choose another "
            "place");
}

}  // namespace
}  // namespace cvg
