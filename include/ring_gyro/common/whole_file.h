#pragma once

#include <optional>
#include <string>

#include "ring_gyro/common/output_file.h"

namespace cvg {

/// A text output with the promises of OutputFile. To be made before a long run: whether the file
/// can be written is told then, and nobody else writes it meanwhile.
///
/// An empty path is an output that was not asked for: nothing is written.
/// Throws std::runtime_error with one line: path, reason, mend.
class WholeFile {
 public:
  explicit WholeFile(const std::string& path);

  void write(const std::string& text);
  /// The file is there. Without it nothing changes.
  void finish();
  /// All of it at once.
  void finish(const std::string& text);

 private:
  void flush();

  std::optional<OutputFile> output_;
  std::string unwritten_;
};

/// A text that is at hand as a whole. Throws as WholeFile.
void writeWholeFile(const std::string& path, const std::string& text);

/// Whether the file could be written now, for one that is written later and more than once.
/// Throws as WholeFile.
void requireWritable(const std::string& path);

}  // namespace cvg
