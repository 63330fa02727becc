"""One writer at a time: a lock on a folder, which the system lets go of when its process ends."""

import contextlib
import fcntl
import os
from collections.abc import Iterator
from pathlib import Path

from pigbench.errors import UserError
from pigbench.support import files


@contextlib.contextmanager
def only_writer(folder: Path) -> Iterator[None]:
    """Holds a folder, made if it is missing. Raises UserError when another process holds it."""
    with files.explaining_full_disk(folder):
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except (FileExistsError, NotADirectoryError):
            raise UserError(f"{folder} is not a folder: choose another") from None
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        if not _take(descriptor):
            raise UserError(
                f"{folder} is being written by another process: wait until it has ended"
            )
        yield
    finally:
        os.close(descriptor)


def is_held(folder: Path) -> bool:
    """Does a process hold the folder as its `only_writer`?"""
    if not folder.is_dir():
        return False
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        return not _take(descriptor)
    finally:
        os.close(descriptor)


def _take(descriptor: int) -> bool:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
