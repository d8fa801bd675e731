#include "ring_gyro/common/output_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <stdexcept>
#include <utility>

#include "ring_gyro/common/write_fault.h"

namespace cvg {
namespace {

constexpr mode_t kPlainMode = 0666;  // reduced by the umask
constexpr int kMostNames = 100;

std::string randomName() {
  static constexpr char kLetters[] = "abcdefghijklmnopqrstuvwxyz0123456789";
  std::random_device random;
  std::string name(6, ' ');
  for (char& letter : name) letter = kLetters[random() % (sizeof kLetters - 1)];
  return name;
}

/// Whether a lock or sync failed only because the file system does not support it.
bool isUnsupported(int reason) {
  return reason == EINVAL || reason == ENOTSUP || reason == ENOSYS || reason == ENOLCK ||
         reason == EROFS;
}

/// A file without a name, which is deleted when it is closed.
Descriptor namelessFile() {
  std::string name = (std::filesystem::temp_directory_path() / "ring_gyro_XXXXXX").string();
  Descriptor file(::mkostemp(name.data(), O_CLOEXEC));
  if (!file.valid()) throw std::runtime_error(writeFault(name, errno));
  ::unlink(name.c_str());
  return file;
}

}  // namespace

OutputFile::OutputFile(std::string path, std::string suffix, Access access)
    : path_(std::move(path)), suffix_(std::move(suffix)), target_(outputTarget(path_)) {
  if (target_.kind == OutputTarget::Kind::kFile) {
    folder_ = Descriptor(::open(target_.folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!folder_.valid()) fail(errno);
    // Renaming does not check the permissions of the file that it replaces.
    if (::faccessat(folder_.number(), target_.name.c_str(), W_OK, AT_EACCESS) != 0 &&
        errno != ENOENT) {
      fail(errno);
    }
    lock();
    return;
  }
  if (target_.kind == OutputTarget::Kind::kDescriptor) {
    const int flags = ::fcntl(target_.descriptor, F_GETFL);
    if (flags < 0) fail(errno);
    if ((flags & O_ACCMODE) == O_RDONLY) fail(EBADF);
    stream_ = Descriptor(::fcntl(target_.descriptor, F_DUPFD_CLOEXEC, 0));
  } else {
    stream_ = Descriptor(
        ::open((target_.folder / target_.name).c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC));
  }
  if (!stream_.valid()) fail(errno);
  if (access == Access::kSeeking) file_ = namelessFile();
}

void OutputFile::fail(int reason) const { throw std::runtime_error(writeFault(path_, reason)); }

void OutputFile::lock() {
  lock_name_ = "." + target_.name + ".lock";
  while (true) {
    Descriptor lock(::openat(folder_.number(), lock_name_.c_str(),
                             O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, kPlainMode));
    if (!lock.valid()) fail(errno);
    while (::flock(lock.number(), LOCK_EX | LOCK_NB) != 0) {
      if (errno == EINTR) continue;
      if (errno == EWOULDBLOCK) {
        throw std::runtime_error(path_ +
                                 ": is being written by another program; wait for its end, or "
                                 "choose another place");
      }
      if (isUnsupported(errno)) break;
      fail(errno);
    }
    // The previous holder may have removed the lock file between the two calls.
    struct stat held = {};
    struct stat there = {};
    if (::fstat(lock.number(), &held) != 0) fail(errno);
    if (::fstatat(folder_.number(), lock_name_.c_str(), &there, AT_SYMLINK_NOFOLLOW) != 0) continue;
    if (held.st_dev != there.st_dev || held.st_ino != there.st_ino) continue;
    lock_ = std::move(lock);
    return;
  }
}

void OutputFile::unlock() noexcept {
  if (!lock_.valid()) return;
  ::unlinkat(folder_.number(), lock_name_.c_str(), 0);
  lock_.close();
}

void OutputFile::makeTemporary() {
  struct stat before = {};
  const bool replaces =
      ::fstatat(folder_.number(), target_.name.c_str(), &before, AT_SYMLINK_NOFOLLOW) == 0;
  const mode_t mode = replaces ? before.st_mode & 0777 : kPlainMode;
  for (int tries = 0; tries < kMostNames; ++tries) {
    const std::string name = target_.name + "." + randomName() + suffix_;
    file_ = Descriptor(::openat(folder_.number(), name.c_str(),
                                O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode));
    if (file_.valid()) {
      temporary_name_ = name;
      break;
    }
    if (errno != EEXIST) fail(errno);
  }
  if (!file_.valid()) fail(EEXIST);
  if (!replaces) return;
  // Only root can set another owner; otherwise the writer owns the new file.
  if (::fchown(file_.number(), before.st_uid, before.st_gid) != 0) errno = 0;
  if (::fchmod(file_.number(), before.st_mode & 07777) != 0) fail(errno);
}

int OutputFile::descriptor() {
  if (!file_.valid() && target_.kind == OutputTarget::Kind::kFile) makeTemporary();
  return file_.valid() ? file_.number() : stream_.number();
}

std::string OutputFile::temporary() const {
  return temporary_name_.empty() ? "" : (target_.folder / temporary_name_).string();
}

void OutputFile::finish() {
  descriptor();
  if (target_.kind == OutputTarget::Kind::kFile) {
    putInPlace();
    unlock();
    return;
  }
  if (file_.valid()) copyIntoStream();
  if (::fsync(stream_.number()) != 0 && !isUnsupported(errno)) fail(errno);
  if (stream_.close() != 0) fail(errno);
}

void OutputFile::putInPlace() {
  const char* const name = target_.name.c_str();
  struct stat before = {};
  // At construction it was a file or did not exist; do not replace anything else.
  if (::fstatat(folder_.number(), name, &before, AT_SYMLINK_NOFOLLOW) == 0 &&
      !S_ISREG(before.st_mode)) {
    fail(EEXIST);
  }
  if (::fsync(file_.number()) != 0 && !isUnsupported(errno)) fail(errno);
  if (file_.close() != 0) fail(errno);
  if (::renameat(folder_.number(), temporary_name_.c_str(), folder_.number(), name) != 0) {
    fail(errno);
  }
  temporary_name_.clear();
  if (::fsync(folder_.number()) != 0 && !isUnsupported(errno)) fail(errno);
}

void OutputFile::copyIntoStream() {
  std::array<char, 65536> bytes;
  off_t at = 0;
  while (true) {
    const ssize_t count = ::pread(file_.number(), bytes.data(), bytes.size(), at);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(errno);
    if (count == 0) return;
    writeAll(stream_.number(), bytes.data(), static_cast<std::size_t>(count), path_);
    at += count;
  }
}

void OutputFile::keep() noexcept {
  temporary_name_.clear();
  discard();
}

void OutputFile::discard() noexcept {
  if (!temporary_name_.empty()) ::unlinkat(folder_.number(), temporary_name_.c_str(), 0);
  temporary_name_.clear();
  file_ = Descriptor();
  unlock();
}

}  // namespace cvg
