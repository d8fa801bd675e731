#include "line_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>

#include "ring_gyro/common/output_target.h"
#include "ring_gyro/common/write_fault.h"

namespace ring_gyro::tools {

LineFile::LineFile(const std::string& path) : path_(path) {
  const cvg::OutputTarget target = cvg::outputTarget(path);
  file_ = cvg::Descriptor(
      target.kind == cvg::OutputTarget::Kind::kDescriptor
          ? ::fcntl(target.descriptor, F_DUPFD_CLOEXEC, 0)
          : ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_NOCTTY | O_CLOEXEC, 0666));
  struct stat status = {};
  if (!file_.valid() || ::fstat(file_.number(), &status) != 0) fail(errno);
  regular_ = S_ISREG(status.st_mode) && target.kind == cvg::OutputTarget::Kind::kFile;
  if (!regular_) return;
  if (::flock(file_.number(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    throw std::runtime_error(path_ +
                             ": is being written by another program; wait for its end, or choose "
                             "another place");
  }
}

bool LineFile::empty() const {
  struct stat status = {};
  if (!regular_) return true;
  if (::fstat(file_.number(), &status) != 0) fail(errno);
  return status.st_size == 0;
}

void LineFile::cutAt(std::size_t length) {
  if (::ftruncate(file_.number(), static_cast<off_t>(length)) != 0) fail(errno);
}

void LineFile::add(const std::string& line) {
  cvg::writeAll(file_.number(), line.data(), line.size(), path_);
}

void LineFile::finish() {
  if (regular_ && ::fsync(file_.number()) != 0) fail(errno);
  if (file_.close() != 0) fail(errno);
}

void LineFile::fail(int reason) const { throw std::runtime_error(cvg::writeFault(path_, reason)); }

}  // namespace ring_gyro::tools
