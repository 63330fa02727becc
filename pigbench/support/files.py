"""Files and folders that are complete or not there at all.

A crash at any moment leaves the old content or the new, never a mixture: content is written under a
temporary name beside its path, synced to disk, and renamed. Only one writer per file at a time; for
folders see `pigbench.support.lock`.
"""

import contextlib
import errno
import fcntl
import hashlib
import json
import os
import resource
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from pigbench.errors import BusyError, UserError

_DISK_FULL = {errno.ENOSPC, errno.EDQUOT}
_SEAL = "checksum"

LOCK = ".lock"
"""The file in a folder that its writer locks (`pigbench.support.lock`)."""


def temporary_path(path: Path) -> Path:
    """Where the content of `path` is written before it is renamed. Always the same name."""
    return path.with_name(f".{path.name}.tmp")


@contextlib.contextmanager
def explaining_full_disk(path: Path) -> Iterator[None]:
    """Turn the operating system's "no space left" within the block into a UserError."""
    try:
        yield
    except Exception as error:
        if not _is_full_disk(error):
            raise
        raise UserError(
            f"no space left on device while writing {path}; free some and run the same command "
            "again: finished parts are kept"
        ) from error


_OF_JSON = AttributeError, KeyError, RecursionError, TypeError, ValueError
"""What is raised over JSON that cannot be parsed, or is not what it should be."""


@contextlib.contextmanager
def explaining_torn(path: Path, *errors: type[Exception]) -> Iterator[None]:
    """Turn what the block raises over the content of `path` into a UserError that names it.

    `errors` are those that the content's format may cause, by default those of JSON.
    """
    expected = errors or _OF_JSON
    try:
        yield
    except expected as error:
        raise UserError(f"{path} is torn: {error}") from None


def _is_full_disk(error: Exception) -> bool:
    # Orbax reports a full disk as an error of its own, in its message only.
    return getattr(error, "errno", None) in _DISK_FULL or "No space left" in str(error)


def nearest(path: Path) -> Path:
    """The path itself if it exists, or else its nearest parent that does."""
    return next(place for place in (path, *path.absolute().parents) if os.path.lexists(place))


def entries(folder: Path) -> set[str]:
    """The names in the folder, except that of a writer's lock."""
    return {path.name for path in folder.iterdir()} - {LOCK}


def require_folder(path: Path) -> None:
    """Raise UserError unless files can be written in the folder `path`; it need not exist yet.

    To be called before long work, so that the work is not lost at the end. Leaves no trace.
    """
    place = nearest(path)
    if not place.is_dir():
        raise UserError(f"{place} is not a folder: choose another")
    try:
        tempfile.TemporaryFile(dir=place).close()
    except OSError as error:
        raise UserError(f"{path} cannot be written: {error.strerror} in {place}") from None


def require_new_folder(path: Path) -> None:
    """Like `require_folder`; also raises UserError if the folder is not empty."""
    require_folder(path)
    if path.is_dir() and entries(path):
        raise UserError(f"{path} is not an empty folder; choose another")


def require_file(path: Path) -> None:
    """Like `require_folder`, for a file; its folder need not exist yet."""
    if path.exists() and not path.is_file():
        raise UserError(f"{path} is not a file: choose another name")
    require_folder(path.parent)


def require_files(*paths: Path | None) -> None:
    """Like `require_file`, for each path that is not None."""
    for path in filter(None, paths):
        require_file(path)


def make_folder(path: Path) -> None:
    """Make the folder and its parents if need be. Raises UserError like `require_folder`."""
    require_folder(path)
    with explaining_full_disk(path):
        path.mkdir(parents=True, exist_ok=True)


@contextlib.contextmanager
def replacing_file(path: Path) -> Iterator[BinaryIO]:
    """A file to write; it replaces `path` when the block ends without an error.

    Its folder is made if need be. Raises BusyError if another process is writing it, and UserError
    if `require_file` does or if the disk is full.
    """
    require_file(path)
    temporary = temporary_path(path)
    with explaining_full_disk(path), _opened_alone(temporary) as file:
        try:
            yield file
            file.flush()
            os.fsync(file.fileno())
            os.replace(temporary, path)
            _sync(path.parent)
        finally:
            temporary.unlink(missing_ok=True)


@contextlib.contextmanager
def _opened_alone(path: Path) -> Iterator[BinaryIO]:
    """The file, truncated, for one process at a time. Raises BusyError in any other process."""
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT, 0o666)
    with open(descriptor, "wb") as file:
        if not take(descriptor, path):
            raise busy(path)
        file.truncate()
        yield file


def busy(path: Path) -> BusyError:
    """The error of whoever would write what another process is writing."""
    return BusyError(f"{path} is being written by another process: wait until it has ended")


def take(descriptor: int, path: Path) -> bool:
    """Lock an open file, and tell whether it is locked and still `path` (not renamed, removed)."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except (BlockingIOError, FileNotFoundError):
        return False


@contextlib.contextmanager
def replacing_folder(path: Path) -> Iterator[Path]:
    """An empty folder to fill with files; it replaces `path` like `replacing_file`.

    Only for one process at a time, as `pigbench.support.lock` ensures. The old content of `path` is
    removed first: a crash in between leaves nothing there. Parent folders are made if need be.
    """
    temporary = temporary_path(path)
    with explaining_full_disk(path):
        try:
            remove_folder(temporary)
            temporary.mkdir(parents=True)
            yield temporary
            for file in temporary.rglob("*"):
                _sync(file)
            _sync(temporary)
            remove_folder(path)
            os.replace(temporary, path)
            _sync(path.parent)
        finally:
            remove_folder(temporary)


def write_bytes(path: Path, content: bytes) -> None:
    """Replace the content of `path`."""
    with replacing_file(path) as file:
        file.write(content)


def write_text(path: Path, text: str) -> None:
    """Replace the content of `path` with `text` in UTF-8, escaping names that are no text."""
    write_bytes(path, text.encode(errors="backslashreplace"))


def write_json(path: Path, value: Any) -> None:
    """Replace the content of `path` with `value` as JSON, with keys in the given order."""
    write_text(path, json.dumps(value, indent=1) + "\n")


def write_sealed(path: Path, value: Mapping[str, Any]) -> None:
    """Replace the content of `path` with `value` as JSON, `sealed`."""
    write_json(path, sealed(value))


def sealed(value: Mapping[str, Any]) -> dict[str, Any]:
    """`value` with the checksum of its JSON, which `unsealed` checks."""
    return {**value, _SEAL: _checksum(value)}


def unsealed(path: Path, value: Any) -> dict[str, Any]:
    """The `sealed` value that was read from `path`. Raises UserError if it has been altered."""
    if not isinstance(value, dict) or _SEAL not in value:
        raise UserError(f"{path} is altered: it has no checksum")
    content = {name: part for name, part in value.items() if name != _SEAL}
    if value[_SEAL] != _checksum(content):
        raise UserError(f"{path} is altered: its checksum does not match")
    return content


def _checksum(value: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(value).encode()).hexdigest()


def append_line(path: Path, line: str) -> None:
    """Append a line to the file `path`, made if it is missing. A crash may leave part of it."""
    with explaining_full_disk(path):
        is_new = not path.exists()
        with open(path, "ab") as file:
            file.write(f"{line}\n".encode())
            file.flush()
            os.fsync(file.fileno())
        if is_new:
            _sync(path.parent)


def read_text(path: Path) -> str:
    """The content of `path`. Raises UserError if it is missing or not UTF-8."""
    try:
        return path.read_text(encoding="utf-8")
    except (FileNotFoundError, NotADirectoryError):
        raise UserError(f"{path} does not exist") from None
    except UnicodeDecodeError:
        raise UserError(f"{path} is torn: it is not text") from None


def read_json(path: Path) -> Any:
    """The value in `path`. Raises UserError if it is missing or not JSON."""
    with explaining_torn(path):
        return json.loads(read_text(path))


def read_sealed(path: Path) -> dict[str, Any]:
    """The value that `write_sealed` wrote. Raises UserError also if it has been altered."""
    with explaining_torn(path):
        return unsealed(path, read_json(path))


def sha256(path: Path) -> str:
    """The SHA-256 of the content of `path`, in hexadecimal."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def require_room(path: Path, need: int) -> None:
    """Raise UserError unless the disk of the folder `path` has `need` bytes free."""
    free = shutil.disk_usage(nearest(path)).free
    if free < need:
        raise UserError(f"{path} needs {need / 1e9:.1f} GB more, and its disk has {free / 1e9:.1f}")


def allow_many_open() -> None:
    """Raise this process's limit of open files, often only 1,024, to what the system permits."""
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    with contextlib.suppress(ValueError, OSError):  # some systems permit less than they report
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))


def remove_folder(path: Path) -> None:
    """Remove the folder `path` and everything in it, if it exists."""
    with contextlib.suppress(FileNotFoundError):
        shutil.rmtree(path)


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
