"""One writer at a time: a lock on a folder, which the system releases when its process ends."""

import contextlib
import fcntl
import os
import time
from collections.abc import Iterator
from pathlib import Path

from pigbench.errors import BusyError
from pigbench.support import files

_TRIES, _PAUSE_SECONDS = 5, 0.02
"""A writer retries, because `is_held` locks a folder for a moment."""


@contextlib.contextmanager
def only_writer(folder: Path) -> Iterator[None]:
    """Hold a folder, made if it is missing.

    Raises BusyError if another process holds it, and UserError if it cannot be written.
    """
    files.make_folder(folder)
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        if not _take_patiently(descriptor):
            raise BusyError(
                f"{folder} is being written by another process: wait until it has ended"
            )
        yield
    finally:
        os.close(descriptor)


def is_held(folder: Path) -> bool:
    """Whether a process holds the folder as its `only_writer`."""
    if not folder.is_dir():
        return False
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        return not _take(descriptor, fcntl.LOCK_SH)
    finally:
        os.close(descriptor)


def _take_patiently(descriptor: int) -> bool:
    for _ in range(_TRIES):
        if _take(descriptor, fcntl.LOCK_EX):
            return True
        time.sleep(_PAUSE_SECONDS)
    return False


def _take(descriptor: int, kind: int) -> bool:
    try:
        fcntl.flock(descriptor, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
