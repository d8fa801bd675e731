#include "ring_gyro/common/write_fault.h"

#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <stdexcept>

namespace cvg {
namespace {

std::string mendOf(const std::string& path, int reason) {
  switch (reason) {
    case ENOSPC:
    case EDQUOT:
      return "make room there, or choose another place";
    case EFBIG:
      return "raise the limit of a file's size (ulimit -f), or write less";
    case EISDIR:
      return "name a file in it";
    case EPIPE:
      return "keep its reader until all has been written";
    case ENAMETOOLONG:
      return "choose a shorter name";
    case ELOOP:
      return "mend the link, or choose another place";
    case ENOENT: {
      if (path[0] == '~') return "the shell has not replaced ~ here; write $HOME instead";
      const std::size_t slash = path.rfind('/');
      const std::string folder = slash == std::string::npos ? "."
                                 : slash == 0               ? "/"
                                                            : path.substr(0, slash);
      return "the folder " + folder + " does not exist; make it or choose another place";
    }
    default:
      return "choose a place that may be written to";
  }
}

/// Blocks SIGPIPE for this thread while it writes.
class WithoutPipeSignal {
 public:
  WithoutPipeSignal() {
    sigemptyset(&pipe_);
    sigaddset(&pipe_, SIGPIPE);
    sigset_t pending;
    sigpending(&pending);
    was_pending_ = sigismember(&pending, SIGPIPE) == 1;
    pthread_sigmask(SIG_BLOCK, &pipe_, &before_);
  }
  ~WithoutPipeSignal() {
    const timespec now{};
    if (!was_pending_) {
      while (sigtimedwait(&pipe_, nullptr, &now) < 0 && errno == EINTR) continue;
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  WithoutPipeSignal(const WithoutPipeSignal&) = delete;
  WithoutPipeSignal& operator=(const WithoutPipeSignal&) = delete;

 private:
  sigset_t pipe_;
  sigset_t before_;
  bool was_pending_;
};

/// 0, or the reason why not all bytes could be written.
int write(int descriptor, const char* data, std::size_t size) {
  const WithoutPipeSignal quiet;
  while (size > 0) {
    const ssize_t written = ::write(descriptor, data, size);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    data += written;
    size -= static_cast<std::size_t>(written);
  }
  return 0;
}

}  // namespace

std::string writeFault(const std::string& path, int reason) {
  return path + ": cannot be written: " + std::strerror(reason) + "; " + mendOf(path, reason);
}

void writeAll(int descriptor, const char* data, std::size_t size, const std::string& path) {
  const int reason = write(descriptor, data, size);
  if (reason != 0) throw std::runtime_error(writeFault(path, reason));
}

}  // namespace cvg
