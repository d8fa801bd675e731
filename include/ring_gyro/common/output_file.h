#pragma once

#include <string>

#include "ring_gyro/common/descriptor.h"
#include "ring_gyro/common/output_target.h"

namespace cvg {

/// Where one output of a program goes: what every writer of the package promises, once.
///
/// - A file is there whole or not at all: it is written beside its place under a name of its own
///   and renamed by finish() when it is on the disk. A link stays and its target is written.
/// - What is no file (device, pipe, /dev/stdout) is written into and never replaced.
/// - Of two writers of one file the second is refused. The lock (.NAME.lock beside the file) goes
///   with the process that holds it, so one that was killed is in nobody's way.
/// - A file keeps its permissions, a new one gets those of the umask.
///
/// Throws std::runtime_error with one line: path, reason, mend.
class OutputFile {
 public:
  enum class Access {
    kSequential,  ///< front to back
    kSeeking      ///< anywhere in it: what cannot seek gets the whole by finish()
  };

  /// `suffix`: end of the name that the file has until it is whole.
  OutputFile(std::string path, std::string suffix, Access access);
  ~OutputFile() { discard(); }
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// As it was given.
  const std::string& path() const { return path_; }
  /// To write to.
  int descriptor();
  /// The name that the file has until it is whole; empty where there is none.
  std::string temporary() const;

  /// All that was written is there under its name, and on the disk.
  void finish();
  /// Leaves what was written under its temporary name, for what has been cut short.
  void keep() noexcept;
  /// Takes back what can be taken back. Nothing after finish() or keep().
  void discard() noexcept;

 private:
  [[noreturn]] void fail(int reason) const;
  void lock();
  void makeTemporary();
  void putInPlace();
  void copyIntoStream();
  void unlock() noexcept;

  std::string path_;
  std::string suffix_;
  OutputTarget target_;
  Descriptor folder_;  // of a file
  Descriptor lock_;    // of a file
  Descriptor stream_;  // what is no file
  Descriptor file_;    // the temporary one, or what is copied into the stream
  std::string lock_name_;
  std::string temporary_name_;
};

}  // namespace cvg
