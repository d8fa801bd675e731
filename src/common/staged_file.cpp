#include "ring_gyro/common/staged_file.h"

#include <cstdio>

#include "ring_gyro/common/output_target.h"

namespace cvg {

StagedFile::StagedFile(const std::string& path) : whole_(path) {
  if (path.empty() || outputTarget(path).kind != OutputTarget::Kind::kFile) return;
  partial_path_ = path + ".partial";
  requireWritable(partial_path_);
}

void StagedFile::keep(const std::string& text) {
  if (partial_path_.empty()) return;
  writeWholeFile(partial_path_, text);
  kept_ = partial_path_;
}

void StagedFile::finish(const std::string& text) {
  whole_.finish(text);
  if (!kept_.empty()) std::remove(kept_.c_str());
  kept_.clear();
}

}  // namespace cvg
