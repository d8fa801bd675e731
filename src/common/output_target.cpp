#include "ring_gyro/common/output_target.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <tuple>

#include "ring_gyro/common/write_fault.h"

namespace cvg {
namespace {

namespace fs = std::filesystem;

constexpr int kMostLinks = 40;  // the limit of the kernel

[[noreturn]] void fail(const std::string& path, int reason) {
  throw std::runtime_error(writeFault(path, reason));
}

fs::path folderOf(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

/// Whether the folder is /proc/self/fd, in any spelling. Its entries are the open files themselves;
/// they must not be followed by name like links.
bool holdsOwnDescriptors(const fs::path& folder) {
  if (folder.filename() != "fd") return false;
  std::error_code ignored;
  const std::string real = fs::canonical(folder, ignored).string();
  return real.rfind("/proc/" + std::to_string(::getpid()) + "/", 0) == 0;
}

/// Identifies a file; for a file that does not exist yet, its folder and its name.
using Identity = std::tuple<dev_t, ino_t, std::string>;

/// Empty for an output that writing cannot destroy, and for a path without an existing folder.
std::optional<Identity> identityOf(const std::string& path) {
  struct stat status = {};
  if (::stat(path.c_str(), &status) == 0) {
    if (S_ISCHR(status.st_mode)) return std::nullopt;
    return Identity(status.st_dev, status.st_ino, "");
  }
  try {
    const OutputTarget target = outputTarget(path);
    if (::stat(target.folder.c_str(), &status) != 0) return std::nullopt;
    return Identity(status.st_dev, status.st_ino, target.name);
  } catch (const std::runtime_error&) {
    return std::nullopt;  // the writer reports the fault
  }
}

}  // namespace

OutputTarget outputTarget(const std::string& path) {
  if (path.empty()) fail(path, ENOENT);
  fs::path at = path;
  for (int links = 0; links <= kMostLinks; ++links) {
    OutputTarget target;
    target.folder = folderOf(at);
    target.name = at.filename().string();
    struct stat status = {};
    if (holdsOwnDescriptors(target.folder)) {
      const char* const end = target.name.data() + target.name.size();
      const auto [stop, error] = std::from_chars(target.name.data(), end, target.descriptor);
      if (error != std::errc() || stop != end || target.descriptor < 0) fail(path, ENOENT);
      target.kind = OutputTarget::Kind::kDescriptor;
      return target;
    }
    if (::stat(at.c_str(), &status) == 0 && !S_ISREG(status.st_mode)) {
      if (S_ISDIR(status.st_mode)) fail(path, EISDIR);
      target.kind = OutputTarget::Kind::kStream;
      return target;
    }
    if (::lstat(at.c_str(), &status) != 0) {
      if (errno != ENOENT) fail(path, errno);
      if (target.name.empty()) fail(path, EISDIR);  // x/
      if (::stat(target.folder.c_str(), &status) != 0) fail(at.string(), errno);
      return target;
    }
    if (!S_ISLNK(status.st_mode)) return target;
    std::error_code error;
    const fs::path next = fs::read_symlink(at, error);
    if (error) fail(path, error.value());
    at = target.folder / next;
  }
  fail(path, ELOOP);
}

void requireApart(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs) {
  for (std::size_t k = 0; k < outputs.size(); ++k) {
    if (outputs[k].empty()) continue;
    const std::optional<Identity> output = identityOf(outputs[k]);
    if (!output) continue;
    for (const std::string& input : inputs) {
      if (input.empty() || identityOf(input) != output) continue;
      throw std::runtime_error(outputs[k] + ": is an input too" +
                               (input == outputs[k] ? "" : " (" + input + ")") +
                               "; name another file for the output");
    }
    for (std::size_t other = 0; other < k; ++other) {
      if (outputs[other].empty() || identityOf(outputs[other]) != output) continue;
      throw std::runtime_error(outputs[k] + ": is another output too" +
                               (outputs[other] == outputs[k] ? "" : " (" + outputs[other] + ")") +
                               "; name a file for each");
    }
  }
}

}  // namespace cvg
