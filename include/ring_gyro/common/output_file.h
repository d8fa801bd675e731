#pragma once

#include <string>

#include "ring_gyro/common/descriptor.h"
#include "ring_gyro/common/output_target.h"

namespace cvg {

/// One output of a program. Every writer of the package uses this class, so all follow these rules:
///
/// - A file appears complete or not at all: it is written in the same folder under a temporary
///   name, and finish() renames it when it is on the disk. A link stays and its target is written.
/// - Anything but a file (device, pipe, /dev/stdout) is written directly and never replaced.
/// - Of two writers of one file the second is refused. The lock (.NAME.lock beside the file) ends
///   with the process that holds it, so a killed process does not block later writers.
/// - A file keeps its permissions; a new file gets those of the umask.
///
/// Throws std::runtime_error with one line: path, reason, remedy.
class OutputFile {
 public:
  enum class Access {
    kSequential,  ///< from beginning to end
    kSeeking      ///< at any position; an output that cannot seek gets the whole text in finish()
  };

  /// `suffix`: end of the temporary name.
  OutputFile(std::string path, std::string suffix, Access access);
  ~OutputFile() { discard(); }
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// The path as given.
  const std::string& path() const { return path_; }
  /// The descriptor to write to.
  int descriptor();
  /// The temporary name; empty if there is none.
  std::string temporary() const;

  /// Puts everything written on the disk under the final name.
  void finish();
  /// Leaves the file under its temporary name, for a run that was cut.
  void keep() noexcept;
  /// Removes the temporary file; bytes already in a stream stay. No effect after finish() or
  /// keep().
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
  Descriptor folder_;  // of the file, if the output is a file
  Descriptor lock_;    // of the file, if the output is a file
  Descriptor stream_;  // if the output is not a file
  Descriptor file_;    // the temporary file, or the text that finish() copies to the stream
  std::string lock_name_;
  std::string temporary_name_;
};

}  // namespace cvg
