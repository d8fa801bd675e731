#pragma once

#include <cstdio>
#include <string>

namespace ring_gyro {

/// One line for a file or folder that could not be written: which, the reason (an errno), the mend.
std::string writeFault(const std::string& path, int reason);

/// A file that is there whole or not at all: written beside its place, renamed by finish().
/// Throws std::runtime_error with the line of writeFault.
class WholeFile {
 public:
  explicit WholeFile(std::string path);
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  void write(const std::string& text);
  void finish();

 private:
  [[noreturn]] void fail() const;

  std::string path_;
  std::string temporary_;
  std::FILE* file_ = nullptr;
};

/// A text that is at hand as a whole. Throws as WholeFile.
void writeWholeFile(const std::string& path, const std::string& text);

/// Whether the file could be written now: to be told before a long run rather than after it.
/// Nothing to do for an empty path. Throws as WholeFile.
void requireWritable(const std::string& path);

}  // namespace ring_gyro
