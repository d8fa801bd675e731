#include "ring_gyro/common/output_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <stdexcept>
#include <thread>

#include "ring_gyro/common/whole_file.h"

namespace cvg {
namespace {

namespace fs = std::filesystem;

std::string contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

template <typename Action>
std::string faultOf(Action action) {
  try {
    action();
    return "";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

class OutputFileTest : public ::testing::Test {
 protected:
  OutputFileTest() {
    fs::create_directory(folder_);
    fs::create_directory(folder_ / "other");
    umask_ = umask(022);
  }
  ~OutputFileTest() override {
    umask(umask_);
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

  fs::path at(const std::string& name) const { return folder_ / name; }
  void make(const std::string& name, const std::string& text) const {
    std::ofstream(at(name)) << text;
  }
  void write(const std::string& name, const std::string& text) const {
    writeWholeFile(at(name).string(), text);
  }
  std::set<std::string> names() const {
    std::set<std::string> result;
    for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
      if (!fs::is_directory(entry.symlink_status())) result.insert(entry.path().filename());
    }
    return result;
  }
  mode_t mode(const std::string& name) const {
    struct stat status = {};
    return stat(at(name).c_str(), &status) == 0 ? status.st_mode & 07777 : 0;
  }

 private:
  fs::path folder_ = fs::temp_directory_path() / ("ring_gyro_output_" + std::to_string(getpid()));
  mode_t umask_;
};

TEST_F(OutputFileTest, ReplacesAFileOfMoreThanTwoGibibytes) {
  make("large", "before");
  fs::resize_file(at("large"), std::uintmax_t{3} << 30);  // a hole, of no size on the disk
  write("large", "after");
  EXPECT_EQ(contents(at("large")), "after");
}

TEST_F(OutputFileTest, FollowsALinkWhateverItsForm) {
  make("target", "before");
  fs::create_symlink("target", at("relative"));
  fs::create_symlink(at("target"), at("absolute"));
  fs::create_symlink("../relative", at("other/chain"));
  for (const std::string name : {"relative", "absolute", "other/chain"}) {
    write(name, name);
    EXPECT_TRUE(fs::is_symlink(at(name)));
    EXPECT_TRUE(fs::is_regular_file(at("target")));
    EXPECT_EQ(contents(at("target")), name);
  }
}

TEST_F(OutputFileTest, MakesTheTargetOfALinkThatLeadsToNothingYet) {
  fs::create_symlink("other/new", at("link"));
  OutputFile file(at("link").string(), ".part", OutputFile::Access::kSequential);
  file.descriptor();
  EXPECT_EQ(fs::path(file.temporary()).parent_path(), at("other"));
  file.finish();
  EXPECT_TRUE(fs::is_symlink(at("link")));
  EXPECT_TRUE(fs::is_regular_file(at("other/new")));
  fs::create_symlink("absent/new", at("lost"));
  EXPECT_NE(faultOf([&] { write("lost", "x"); }).find("No such file or directory; the folder"),
            std::string::npos);
  fs::create_symlink("circle", at("circle"));
  EXPECT_NE(faultOf([&] { write("circle", "x"); }).find("mend the link"), std::string::npos);
}

TEST_F(OutputFileTest, WritesIntoAPipe) {
  ASSERT_EQ(mkfifo(at("pipe").c_str(), 0600), 0);
  fs::create_symlink("pipe", at("link"));
  for (const auto access : {OutputFile::Access::kSequential, OutputFile::Access::kSeeking}) {
    for (const std::string name : {"pipe", "link"}) {
      std::string got;
      std::thread reader([&] { got = contents(at(name)); });
      OutputFile file(at(name).string(), ".part", access);
      EXPECT_EQ(::write(file.descriptor(), "text", 4), 4);
      file.finish();
      reader.join();
      EXPECT_EQ(got, "text");
      EXPECT_TRUE(fs::is_fifo(at("pipe")));
    }
  }
  EXPECT_EQ(names(), (std::set<std::string>{"pipe", "link"}));
}

TEST_F(OutputFileTest, SaysThatAPipesReaderHasGone) {
  ASSERT_EQ(mkfifo(at("pipe").c_str(), 0600), 0);
  const int reader = open(at("pipe").c_str(), O_RDONLY | O_NONBLOCK);
  WholeFile file(at("pipe").string());
  close(reader);
  EXPECT_NE(faultOf([&] { file.finish("text"); }).find("Broken pipe; keep its reader"),
            std::string::npos);
}

TEST_F(OutputFileTest, WritesIntoADevice) {
  if (mknod(at("null").c_str(), S_IFCHR | 0666, makedev(1, 3)) != 0 ||
      mknod(at("full").c_str(), S_IFCHR | 0666, makedev(1, 7)) != 0) {
    GTEST_SKIP() << "only root can make a device";
  }
  // Where the folder lies on a file system that takes no devices they cannot be opened.
  const int opened = open(at("null").c_str(), O_WRONLY);
  if (opened < 0) GTEST_SKIP() << "no devices in " << at("");
  close(opened);
  write("null", "text");
  EXPECT_TRUE(fs::is_character_file(at("null")));
  EXPECT_NE(faultOf([&] { write("full", "text"); }).find("No space left on device; make room"),
            std::string::npos);
  EXPECT_TRUE(fs::is_character_file(at("full")));
}

TEST_F(OutputFileTest, WritesIntoADescriptorOfItsOwn) {
  make("log", "before ");
  const int descriptor = open(at("log").c_str(), O_WRONLY | O_APPEND);
  const std::string number = std::to_string(descriptor);
  for (const std::string folder : {"/dev/fd/", "/proc/self/fd/", "/proc/thread-self/fd/"}) {
    writeWholeFile(folder + number, "text ");
  }
  fs::create_symlink("/dev/fd/" + number, at("link"));
  write("link", "text");
  close(descriptor);
  EXPECT_EQ(contents(at("log")), "before text text text text");
  EXPECT_NE(faultOf([&] { writeWholeFile("/dev/fd/" + number, "x"); }), "");
  // Beyond what a descriptor can be: not another one.
  for (const char* none : {"4294967297", "18446744073709551617", "-1", "1x", " 1"}) {
    EXPECT_NE(faultOf([&] { writeWholeFile(std::string("/dev/fd/") + none, "x"); }), "") << none;
  }
}

TEST_F(OutputFileTest, RefusesASecondWriterUntilTheFirstHasEnded) {
  fs::create_symlink("x", at("link"));
  {
    OutputFile first(at("x").string(), ".part", OutputFile::Access::kSequential);
    first.descriptor();
    for (const std::string name : {"x", "link", "other/../x"}) {
      const std::string fault = faultOf([&] { write(name, "second"); });
      EXPECT_NE(fault.find("is being written by another program"), std::string::npos) << name;
    }
    EXPECT_TRUE(fs::exists(first.temporary()));
    write("y", "another file");
    first.finish();
  }
  write("x", "next");
  EXPECT_EQ(contents(at("x")), "next");
  EXPECT_EQ(names(), (std::set<std::string>{"link", "x", "y"}));
}

TEST_F(OutputFileTest, IsNotHeldUpByAWriterThatWasKilled) {
  const pid_t child = fork();
  if (child == 0) {
    OutputFile file(at("x").string(), ".active", OutputFile::Access::kSeeking);
    const bool written = ::write(file.descriptor(), "half", 4) == 4;
    kill(getpid(), SIGKILL);
    _exit(written ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  const std::set<std::string> left = names();
  write("x", "whole");
  EXPECT_EQ(contents(at("x")), "whole");
  // What it left is there to be found, and nobody's to remove.
  std::string half;
  for (const std::string& name : names()) {
    if (name.size() == 15 && name.rfind("x.", 0) == 0) half = name;
  }
  EXPECT_EQ(left.count(half), 1u);
  EXPECT_EQ(half.substr(8), ".active");
  EXPECT_EQ(contents(at(half)), "half");
}

TEST_F(OutputFileTest, TouchesNothingThatStandsInItsWay) {
  make("precious", "precious");
  for (const std::string name : {"x.part", "x.active"}) fs::create_symlink("precious", at(name));
  write("x", "text");
  EXPECT_EQ(contents(at("precious")), "precious");
  EXPECT_TRUE(fs::is_symlink(at("x.part")));
  fs::create_symlink("precious", at(".y.lock"));
  EXPECT_NE(faultOf([&] { write("y", "text"); }), "");
  EXPECT_EQ(contents(at("precious")), "precious");
  // What has come in its place since it was asked for.
  WholeFile file(at("z").string());
  ASSERT_EQ(mkfifo(at("z").c_str(), 0600), 0);
  EXPECT_NE(faultOf([&] { file.finish("text"); }), "");
  EXPECT_TRUE(fs::is_fifo(at("z")));
}

TEST_F(OutputFileTest, KeepsPermissions) {
  write("new", "x");
  EXPECT_EQ(mode("new"), 0644u);
  umask(077);
  write("private", "x");
  EXPECT_EQ(mode("private"), 0600u);
  for (const mode_t kept : {0600, 0664, 0666, 0755}) {
    ASSERT_EQ(chmod(at("new").c_str(), kept), 0);
    write("new", "y");
    EXPECT_EQ(mode("new"), kept);
  }
}

TEST_F(OutputFileTest, SaysWhyAWriteFellShort) {
  rlimit before = {};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit = before;
  limit.rlim_cur = 70000;
  setrlimit(RLIMIT_FSIZE, &limit);
  // The first write is short and sets no errno at all.
  errno = EPERM;
  const std::string fault = faultOf([&] { write("x", std::string(100000, 'x')); });
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(fault, at("x").string() +
                       ": cannot be written: File too large; raise the limit of a file's size "
                       "(ulimit -f), or write less");
  EXPECT_TRUE(names().empty());
}

TEST_F(OutputFileTest, TryingAPipeDoesNotEndItForItsReader) {
  ASSERT_EQ(mkfifo(at("pipe").c_str(), 0600), 0);
  requireWritable(at("pipe").string());  // would wait for a reader
  EXPECT_TRUE(fs::is_fifo(at("pipe")));
}

class ApartTest : public OutputFileTest {
 protected:
  std::string fault(const std::vector<std::string>& outputs,
                    const std::vector<std::string>& inputs) const {
    const auto paths = [this](const std::vector<std::string>& names) {
      std::vector<std::string> result;
      for (const std::string& name : names) result.push_back(name.empty() ? "" : at(name).string());
      return result;
    };
    return faultOf([&] { requireApart(paths(outputs), paths(inputs)); });
  }
};

TEST_F(ApartTest, RefusesAnOutputThatIsAnInput) {
  make("in", "x");
  make("in2", "x");
  fs::create_symlink("in", at("link"));
  fs::create_hard_link(at("in"), at("hard"));
  fs::create_directory_symlink("other", at("folder"));
  make("other/in", "x");
  for (const std::string out : {"in", "link", "hard", "./in", "other/../in"}) {
    EXPECT_NE(fault({out}, {"in2", "in"}).find("is an input too"), std::string::npos) << out;
    EXPECT_NE(fault({"", out}, {"", "link"}).find("is an input too"), std::string::npos) << out;
  }
  EXPECT_NE(fault({"folder/in"}, {"other/in"}), "");
  EXPECT_EQ(fault({"out", "", "other/in"}, {"in", "in2", "absent", ""}), "");
}

TEST_F(ApartTest, RefusesTwoOutputsThatAreOne) {
  fs::create_symlink("new", at("link"));
  fs::create_directory_symlink("other", at("folder"));
  EXPECT_NE(fault({"new", "new"}, {}).find("is another output too"), std::string::npos);
  EXPECT_NE(fault({"new", "", "./new"}, {}), "");
  EXPECT_NE(fault({"link", "new"}, {}), "");
  EXPECT_NE(fault({"folder/new", "other/new"}, {}), "");
  EXPECT_EQ(fault({"new", "other/new", "", ""}, {}), "");
  EXPECT_EQ(faultOf([] { requireApart({"/dev/null", "/dev/null"}, {"/dev/null"}); }), "");
}

}  // namespace
}  // namespace cvg
