#pragma once

#include <string>

#include "ring_gyro/common/whole_file.h"

namespace cvg {

/// A file that a long run completes at its end; what there is until then is kept beside it, so that
/// a run that fails or is killed leaves what it has found, and never over the file of an earlier
/// run. Nobody else writes the file meanwhile.
class StagedFile {
 public:
  /// Empty: nothing is written at all. Throws as WholeFile when the file, or the one beside it,
  /// cannot be written.
  explicit StagedFile(const std::string& path);

  /// What there is so far, in place of what was kept before. Nothing is kept beside what is no
  /// regular file, such as a pipe. Throws as WholeFile.
  void keep(const std::string& text);
  /// The whole. What was kept is removed. Throws as WholeFile.
  void finish(const std::string& text);

  /// Where this run has kept something; empty when it has not.
  const std::string& kept() const { return kept_; }

 private:
  WholeFile whole_;
  std::string partial_path_;  // empty: nothing is kept
  std::string kept_;
};

}  // namespace cvg
