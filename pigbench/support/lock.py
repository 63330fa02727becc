"""One writer at a time: a lock, which the system releases when its process ends.

The lock is on a file opened for writing, because NFS has no locks on folders: only that is locked
for all machines. The file is in the locked folder, so it is the same however the folder is reached
or mounted. It does not count as content of the folder (`files.entries`), and the writer removes it
at the end. One that a killed process left is locked by nobody and does no harm.

The library `filelock` (4.3) cannot do this: it leaves its file where it was, cannot look at a lock
without taking it, for which the file must be writable, and locks only files that it opens itself,
whereas `files.replacing_file` locks the one that it writes.
"""

import contextlib
import fcntl
import os
import time
from collections.abc import Iterator
from pathlib import Path

from pigbench.errors import UserError
from pigbench.support import files

_TRIES, _PAUSE_SECONDS = 5, 0.02
"""A writer retries, because `is_held` takes the lock for a moment."""


@contextlib.contextmanager
def only_writer(folder: Path) -> Iterator[None]:
    """Hold a folder, made if it is missing.

    Raises BusyError if another process holds it, and UserError if it cannot be written.
    """
    files.make_folder(folder)
    with _holding(folder, folder / files.LOCK):
        yield


@contextlib.contextmanager
def replacing_folder(path: Path) -> Iterator[Path]:
    """As `files.replacing_folder`, for one process at a time.

    Raises BusyError if another process replaces or holds `path`, and UserError if it cannot be
    written.
    """
    if not path.name:
        raise UserError(f"{path} is where the command runs: name a folder in it")
    files.make_folder(path.parent)
    beside = path.with_name(f".{path.name}{files.LOCK}")  # within, it would be replaced too
    with _holding(path, beside):
        if is_held(path):
            raise files.busy(path)
        with files.replacing_folder(path) as new:
            yield new


def is_held(folder: Path) -> bool:
    """Whether a process holds the folder as its `only_writer`."""
    try:
        descriptor = os.open(folder / files.LOCK, os.O_RDONLY)
    except (FileNotFoundError, NotADirectoryError):
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(descriptor)
    return False


@contextlib.contextmanager
def _holding(path: Path, lock: Path) -> Iterator[None]:
    """Hold `path` by the file `lock`."""
    try:
        descriptor = _take_patiently(lock)
    except OSError as error:  # another user's file, or a file system without locks
        raise UserError(f"{path} cannot be locked: {error.strerror} for {lock}") from None
    if descriptor is None:
        raise files.busy(path)
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            lock.unlink()  # before releasing it: who waits for it sees that it is gone
        os.close(descriptor)


def _take_patiently(lock: Path) -> int | None:
    for _ in range(_TRIES):
        descriptor = os.open(lock, os.O_RDWR | os.O_CREAT, 0o666)
        if files.take(descriptor, lock):
            return descriptor
        os.close(descriptor)
        time.sleep(_PAUSE_SECONDS)
    return None
