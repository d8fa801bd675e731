"""Files that the commands write, with the promises of include/ring_gyro/common/output_file.h.

A file is there whole or not at all; a link stays and its target is written; what is no file (pipe,
device, /dev/stdout) is written into and never replaced; of two writers of one file the second is
refused; no output is also an input. Everything raises ToolError with one line: path, reason, mend.
"""

import errno
import fcntl
import os
import secrets
import stat
import sys

from .tools import ToolError

MOST_LINKS = 40     # as the kernel
PLAIN_MODE = 0o666  # less the umask
UNSUPPORTED = (errno.EINVAL, errno.ENOTSUP, errno.ENOSYS, errno.ENOLCK, errno.EROFS)
MENDS = {
    errno.ENOSPC: "make room there, or choose another place",
    errno.EDQUOT: "make room there, or choose another place",
    errno.EFBIG: "raise the limit of a file's size (ulimit -f), or write less",
    errno.EISDIR: "name a file in it",
    errno.EPIPE: "keep its reader until all has been written",
    errno.ENAMETOOLONG: "choose a shorter name",
    errno.ELOOP: "mend the link, or choose another place",
}


def write_fault(path, reason: int) -> ToolError:
    mend = MENDS.get(reason, "choose a place that may be written to")
    if reason == errno.ENOENT:
        mend = "the shell has not replaced ~ here; write $HOME instead" \
            if os.fspath(path).startswith("~") else (
                f"the folder {os.path.dirname(path) or '.'} does not exist; make it or choose "
                "another place")
    return ToolError(f"{path}: cannot be written: {os.strerror(reason)}; {mend}")


def status_of(path, follow: bool = True):
    try:
        return os.stat(path, follow_symlinks=follow)
    except OSError as error:
        if error.errno in (errno.ENOENT, errno.ELOOP):
            return None
        raise write_fault(path, error.errno) from None


def own_descriptor(path: str):
    """N of /dev/fd/N, /proc/self/fd/N: no link to be followed by name, but the open file itself."""
    folder = os.path.realpath(os.path.dirname(path) or ".")
    if not folder.startswith(f"/proc/{os.getpid()}/") or os.path.basename(folder) != "fd":
        return None
    name = os.path.basename(path)
    if not name.isdigit():
        raise write_fault(path, errno.ENOENT)
    return int(name)


def target_of(path) -> "tuple[str, int | None, bool]":
    """Where a path leads, links followed; a descriptor of this process; whether it is a file."""
    path = os.fspath(path)
    at = path
    for _ in range(MOST_LINKS + 1):
        descriptor = own_descriptor(at)
        if descriptor is not None:
            return at, descriptor, False
        found = status_of(at)
        if found and stat.S_ISDIR(found.st_mode) or not os.path.basename(at):
            raise write_fault(path, errno.EISDIR)
        if found and not stat.S_ISREG(found.st_mode):
            return at, None, False
        if not os.path.islink(at):
            if not os.path.isdir(os.path.dirname(at) or "."):
                raise write_fault(at, errno.ENOENT)
            return at, None, True
        at = os.path.join(os.path.dirname(at), os.readlink(at))
    raise write_fault(path, errno.ELOOP)


def identity_of(path):
    """What tells files apart; None for what cannot be destroyed by writing to it."""
    found = status_of(path)
    if found:
        return None if stat.S_ISCHR(found.st_mode) else (found.st_dev, found.st_ino, "")
    at = target_of(path)[0]
    folder = os.stat(os.path.dirname(at) or ".")
    return folder.st_dev, folder.st_ino, os.path.basename(at)


def require_apart(outputs, inputs) -> None:
    """Refuses an output that is the same file as an input or as another output, however spelled."""
    known = {}
    for path in inputs:
        if path and status_of(path):
            known[identity_of(path)] = (path, "an input")
    for path in outputs:
        if not path:
            continue
        identity = identity_of(path)
        if identity is not None and identity in known:
            other, what = known[identity]
            spelled = "" if os.fspath(other) == os.fspath(path) else f" ({other})"
            raise ToolError(f"{path}: is {what} too{spelled}; name another file for the output")
        known[identity] = (path, "another output")


def write_all(descriptor: int, data: bytes) -> None:
    """In as many calls as that takes, so that the reason for which one fails is its own."""
    left = memoryview(data)
    while left:
        left = left[os.write(descriptor, left):]


def sync(descriptor: int) -> None:
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in UNSUPPORTED:
            raise


def lock(descriptor: int, path) -> None:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise ToolError(f"{path}: is being written by another program; wait for its end, or choose "
                        "another place") from None
    except OSError as error:
        if error.errno not in UNSUPPORTED:
            raise


class OutputFile:
    """One file: `with OutputFile(path) as file: ...; file.finish(data)`. Nothing without finish."""

    def __init__(self, path):
        self.path = os.fspath(path)
        at, descriptor, is_file = target_of(self.path)
        self._name = os.path.basename(at)
        self._lock_name = f".{self._name}.lock"
        self._folder = self._lock = self._stream = None
        try:
            if is_file:
                self._folder = os.open(os.path.dirname(at) or ".", os.O_RDONLY | os.O_DIRECTORY)
                # Renaming asks for no leave of the file that it takes the place of.
                if os.path.exists(at) and not os.access(at, os.W_OK, effective_ids=True):
                    raise PermissionError(errno.EACCES, "")
                self._take_lock()
            elif descriptor is not None:
                if fcntl.fcntl(descriptor, fcntl.F_GETFL) & os.O_ACCMODE == os.O_RDONLY:
                    raise OSError(errno.EBADF, "")
                sys.stdout.flush()  # what was printed before stands before
                self._stream = os.dup(descriptor)
            else:
                self._stream = os.open(at, os.O_WRONLY | os.O_NOCTTY)
        except OSError as error:
            self.close()
            raise write_fault(self.path, error.errno) from None
        except ToolError:
            self.close()
            raise

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _take_lock(self) -> None:
        flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW
        while True:
            held = os.open(self._lock_name, flags, PLAIN_MODE, dir_fd=self._folder)
            try:
                lock(held, self.path)
                there = os.stat(self._lock_name, dir_fd=self._folder, follow_symlinks=False)
                if os.path.samestat(os.fstat(held), there):
                    self._lock = held
                    return
            except FileNotFoundError:
                pass  # whoever held it before has removed it between the two calls
            finally:
                if self._lock is None:
                    os.close(held)

    def finish(self, data) -> None:
        """The file is there, and on the disk."""
        data = data if isinstance(data, bytes) else data.encode()
        try:
            if self._folder is None:
                write_all(self._stream, data)
                sync(self._stream)
            else:
                self._put_in_place(data)
        except OSError as error:
            raise write_fault(self.path, error.errno) from None
        finally:
            self.close()

    def _put_in_place(self, data: bytes) -> None:
        try:
            before = os.stat(self._name, dir_fd=self._folder, follow_symlinks=False)
        except FileNotFoundError:
            before = None
        if before and not stat.S_ISREG(before.st_mode):
            raise FileExistsError(errno.EEXIST, "")
        name = f"{self._name}.{secrets.token_hex(3)}.part"
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW
        mode = before.st_mode & 0o777 if before else PLAIN_MODE
        file = os.open(name, flags, mode, dir_fd=self._folder)
        try:
            try:
                if before:
                    try:
                        os.fchown(file, before.st_uid, before.st_gid)
                    except PermissionError:
                        pass  # only root can give a file away
                    os.fchmod(file, before.st_mode & 0o7777)
                write_all(file, data)
                sync(file)
            finally:
                os.close(file)
            os.replace(name, self._name, src_dir_fd=self._folder, dst_dir_fd=self._folder)
        except BaseException:
            os.unlink(name, dir_fd=self._folder)
            raise
        sync(self._folder)

    def close(self) -> None:
        if self._lock is not None:
            try:
                os.unlink(self._lock_name, dir_fd=self._folder)
            except OSError:
                pass
        for descriptor in (self._lock, self._stream, self._folder):
            if descriptor is not None:
                os.close(descriptor)
        self._lock = self._stream = self._folder = None


def write_whole(path, data) -> None:
    """Text or bytes, all at once."""
    with OutputFile(path) as file:
        file.finish(data)
