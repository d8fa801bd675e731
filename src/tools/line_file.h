#pragma once

#include <cstddef>
#include <string>

#include "ring_gyro/common/descriptor.h"

namespace ring_gyro::tools {

/// A file that grows by complete lines while its only writer works; an output that is not a file
/// (pipe, terminal) is written line by line. Throws std::runtime_error with one line: path, reason,
/// remedy.
class LineFile {
 public:
  /// Creates a missing file. A second writer is refused during the life of this object.
  explicit LineFile(const std::string& path);

  /// Whether it is a file, with lines that can be read again, rather than a pipe or a terminal.
  bool isFile() const { return regular_; }
  bool empty() const;
  /// Keeps only the first `length` bytes. Only for files.
  void cutAt(std::size_t length);
  void add(const std::string& line);
  /// Puts all lines on the disk.
  void finish();

 private:
  [[noreturn]] void fail(int reason) const;

  std::string path_;
  cvg::Descriptor file_;
  bool regular_;
};

}  // namespace ring_gyro::tools
