#pragma once

#include <string>

#include "ring_gyro/common/whole_file.h"

namespace cvg {

/// A file that a long run completes at its end. Until then the results so far are in a second file
/// beside it. So a run that fails or is killed leaves its results and does not overwrite the file
/// of an earlier run. No other program can write the file during the run.
class StagedFile {
 public:
  /// Empty path: nothing is written. Throws like WholeFile if the file, or the one beside it,
  /// cannot be written.
  explicit StagedFile(const std::string& path);

  /// Writes the results so far, replacing those of the last keep(). Does nothing if the output is
  /// not a regular file, for example a pipe. Throws like WholeFile.
  void keep(const std::string& text);
  /// Writes the complete file and removes the second one. Throws like WholeFile.
  void finish(const std::string& text);

  /// Path of the results so far; empty if keep() has written none.
  const std::string& kept() const { return kept_; }

 private:
  WholeFile whole_;
  std::string partial_path_;  // empty: keep() writes nothing
  std::string kept_;
};

}  // namespace cvg
