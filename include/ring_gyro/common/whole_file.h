#pragma once

#include <optional>
#include <string>

#include "ring_gyro/common/output_file.h"

namespace cvg {

/// A text output that follows the rules of OutputFile. Construct it before a long run: then a file
/// that cannot be written is reported at once, and no other program can write it during the run.
///
/// An empty path means that no output was requested: nothing is written.
/// Throws std::runtime_error with one line: path, reason, remedy.
class WholeFile {
 public:
  explicit WholeFile(const std::string& path);

  void write(const std::string& text);
  /// Makes the file appear. Without this call no file changes.
  void finish();
  /// Writes the whole text and finishes.
  void finish(const std::string& text);

 private:
  void flush();

  std::optional<OutputFile> output_;
  std::string unwritten_;
};

/// Writes a file from a text that is already complete. Throws like WholeFile.
void writeWholeFile(const std::string& path, const std::string& text);

/// Checks that the file can be written now; for a file that is written later and more than once.
/// Throws like WholeFile.
void requireWritable(const std::string& path);

}  // namespace cvg
