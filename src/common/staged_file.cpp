#include "ring_gyro/common/staged_file.h"

#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "ring_gyro/common/whole_file.h"

namespace ring_gyro {

StagedFile::StagedFile(std::string path) : path_(std::move(path)) {
  requireWritable(path_);
  std::error_code ignored;  // a file that is not there yet will be a regular one
  const std::filesystem::file_status status = std::filesystem::status(path_, ignored);
  if (path_.empty() || (exists(status) && !is_regular_file(status))) return;
  partial_path_ = path_ + ".partial";
  requireWritable(partial_path_);
}

void StagedFile::keep(const std::string& text) {
  if (partial_path_.empty()) return;
  writeWholeFile(partial_path_, text);
  kept_ = partial_path_;
}

void StagedFile::finish(const std::string& text) {
  if (path_.empty()) return;
  writeWholeFile(path_, text);
  if (!kept_.empty()) std::remove(kept_.c_str());
  kept_.clear();
}

}  // namespace ring_gyro
