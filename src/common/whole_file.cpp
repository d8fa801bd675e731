#include "ring_gyro/common/whole_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace ring_gyro {
namespace {

std::string mendOf(const std::string& path, int reason) {
  if (reason == ENOSPC) return "make room there, or choose another place";
  if (reason == EISDIR) return "name a file in it";
  if (reason != ENOENT) return "choose a place that may be written to";
  const std::size_t slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash);
  return "the folder " + folder + " does not exist; make it or choose another place";
}

}  // namespace

std::string writeFault(const std::string& path, int reason) {
  return path + ": cannot be written: " + std::strerror(reason) + "; " + mendOf(path, reason);
}

WholeFile::WholeFile(std::string path) : path_(std::move(path)), temporary_(path_ + ".part") {
  std::error_code ignored;
  if (std::filesystem::is_directory(path_, ignored)) {
    throw std::runtime_error(writeFault(path_, EISDIR));
  }
  file_ = std::fopen(temporary_.c_str(), "wb");
  if (!file_) fail();
}

WholeFile::~WholeFile() {
  if (!file_) return;
  std::fclose(file_);
  std::remove(temporary_.c_str());
}

void WholeFile::write(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) fail();
}

void WholeFile::finish() {
  std::FILE* const file = std::exchange(file_, nullptr);
  if (std::fclose(file) == 0 && std::rename(temporary_.c_str(), path_.c_str()) == 0) return;
  const int reason = errno;
  std::remove(temporary_.c_str());
  throw std::runtime_error(writeFault(path_, reason));
}

void WholeFile::fail() const { throw std::runtime_error(writeFault(path_, errno)); }

void writeWholeFile(const std::string& path, const std::string& text) {
  WholeFile file(path);
  file.write(text);
  file.finish();
}

void requireWritable(const std::string& path) {
  if (!path.empty()) WholeFile file(path);
}

}  // namespace ring_gyro
