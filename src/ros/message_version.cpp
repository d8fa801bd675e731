#include "ring_gyro/ros/message_version.h"

#include <sys/stat.h>

#include "ring_gyro/common/shell_word.h"

namespace ring_gyro::bridge {
namespace {

constexpr char kExtension[] = ".bag";  // rosbag fix writes no other

bool isThere(const std::string& path) {
  struct stat status = {};
  return lstat(path.c_str(), &status) == 0;
}

/// "run.bag" gives "run_fixed.bag", or "run_fixed2.bag" if that exists, because rosbag fix replaces
/// a file without asking.
std::string freeName(const std::string& path) {
  const std::size_t length = sizeof kExtension - 1;
  const bool extended =
      path.size() > length && path.compare(path.size() - length, length, kExtension) == 0;
  const std::string stem = (extended ? path.substr(0, path.size() - length) : path) + "_fixed";
  std::string name = stem + kExtension;
  for (int i = 2; isThere(name); ++i) name = stem + std::to_string(i) + kExtension;
  return name;
}

}  // namespace

std::string fixCommand(const BagFile& bag) {
  return "rosbag fix " + cvg::shellWord(bag.path()) + " " + cvg::shellWord(freeName(bag.path()));
}

void requireVersion(const BagFile& bag, const BagConnection& connection, const std::string& md5) {
  if (connection.md5 == md5) return;
  throw BagError(bag.path() + ": topic " + connection.topic + ": " + connection.type +
                 " of another version of this package (md5 " + connection.md5 + ", here " + md5 +
                 "); convert the bag: " +
                 (bag.hasIndex() ? "" : "rosbag reindex " + cvg::shellWord(bag.path()) + " && ") +
                 fixCommand(bag));
}

}  // namespace ring_gyro::bridge
