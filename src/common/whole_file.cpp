#include "ring_gyro/common/whole_file.h"

#include "ring_gyro/common/write_fault.h"

namespace cvg {
namespace {

constexpr std::size_t kEnoughForAWrite = 65536;  // bytes

}  // namespace

WholeFile::WholeFile(const std::string& path) {
  if (!path.empty()) output_.emplace(path, ".part", OutputFile::Access::kSequential);
}

void WholeFile::write(const std::string& text) {
  if (!output_) return;
  unwritten_ += text;
  if (unwritten_.size() >= kEnoughForAWrite) flush();
}

void WholeFile::flush() {
  writeAll(output_->descriptor(), unwritten_.data(), unwritten_.size(), output_->path());
  unwritten_.clear();
}

void WholeFile::finish() {
  if (!output_) return;
  flush();
  output_->finish();
  output_.reset();
}

void WholeFile::finish(const std::string& text) {
  write(text);
  finish();
}

void writeWholeFile(const std::string& path, const std::string& text) {
  WholeFile(path).finish(text);
}

void requireWritable(const std::string& path) {
  // Do not open a pipe here: closing it again would end it for its reader.
  if (path.empty() || outputTarget(path).kind != OutputTarget::Kind::kFile) return;
  const WholeFile file(path);
}

}  // namespace cvg
