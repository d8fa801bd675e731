#pragma once

#include <cstddef>
#include <string>

#include "ring_gyro/common/descriptor.h"

namespace ring_gyro::tools {

/// A file that grows by whole lines while its one writer works; what is no file (pipe, terminal) is
/// written into line by line. Throws std::runtime_error with one line: path, reason, mend.
class LineFile {
 public:
  /// Made when it is missing. A second writer is refused as long as this one is there.
  explicit LineFile(const std::string& path);

  /// Whether it is a file, with lines that can be read again, rather than a pipe or a terminal.
  bool isFile() const { return regular_; }
  bool empty() const;
  /// Drops what stands behind the first `length` bytes. Not for what is no file.
  void cutAt(std::size_t length);
  void add(const std::string& line);
  /// All lines are on the disk.
  void finish();

 private:
  [[noreturn]] void fail(int reason) const;

  std::string path_;
  cvg::Descriptor file_;
  bool regular_;
};

}  // namespace ring_gyro::tools
