#include "ring_gyro/common/whole_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

namespace ring_gyro {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& temporary) {
  const std::string reason = std::strerror(errno);
  std::remove(temporary.c_str());
  throw std::runtime_error(path + ": cannot be written: " + reason);
}

}  // namespace

void writeWholeFile(const std::string& path, const std::string& text) {
  const std::string temporary = path + ".part";
  std::FILE* file = std::fopen(temporary.c_str(), "wb");
  if (!file) fail(path, temporary);
  const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  const bool closed = std::fclose(file) == 0;
  if (!written || !closed || std::rename(temporary.c_str(), path.c_str()) != 0) {
    fail(path, temporary);
  }
}

void requireWritable(const std::string& path) {
  const std::string temporary = path + ".part";
  std::FILE* file = std::fopen(temporary.c_str(), "wb");
  if (!file) fail(path, temporary);
  std::fclose(file);
  std::remove(temporary.c_str());
}

}  // namespace ring_gyro
