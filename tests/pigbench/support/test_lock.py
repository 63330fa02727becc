import errno
import fcntl
import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from pigbench.errors import UserError
from pigbench.support import files
from pigbench.support.lock import is_held, only_writer, replacing_folder

HOLD = """
import sys, time
from pathlib import Path
from pigbench.support.lock import only_writer
with only_writer(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(600)
"""


@pytest.fixture
def holder(tmp_path):
    with subprocess.Popen(
        [sys.executable, "-P", "-c", HOLD, tmp_path / "run"], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "held\n"
        yield process
        process.kill()


def test_another_process_is_kept_out_until_the_first_is_killed(holder, tmp_path):
    assert is_held(tmp_path / "run")
    with (
        pytest.raises(UserError, match="is being written by another process"),
        only_writer(tmp_path / "run"),
    ):
        pass
    holder.kill()
    holder.wait()
    assert not is_held(tmp_path / "run")
    files.require_new_folder(tmp_path / "run")  # what the killed one left is nothing
    with only_writer(tmp_path / "run"):
        assert is_held(tmp_path / "run")
        files.require_new_folder(tmp_path / "run")
    assert os.listdir(tmp_path / "run") == []


def test_what_is_not_there_is_not_held(tmp_path):
    assert not is_held(tmp_path / "nothing")


def test_one_who_asks_keeps_nobody_out(tmp_path):
    (tmp_path / ".lock").touch()
    descriptor = os.open(tmp_path / ".lock", os.O_RDONLY)
    fcntl.flock(descriptor, fcntl.LOCK_SH)  # as is_held does, for a moment
    assert not is_held(tmp_path)
    threading.Timer(0.03, os.close, [descriptor]).start()
    with only_writer(tmp_path):
        pass


def test_a_file_is_no_folder(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="is not a folder"), only_writer(tmp_path / "file"):
        pass


def test_it_holds_on_nfs(tmp_path, monkeypatch):
    """There flock(2) is for regular files, and takes what is open for writing to hold it alone."""
    local = fcntl.flock

    def flock(descriptor: int, operation: int) -> None:
        writable = fcntl.fcntl(descriptor, fcntl.F_GETFL) & os.O_ACCMODE != os.O_RDONLY
        regular = stat.S_ISREG(os.fstat(descriptor).st_mode)
        if not regular or not (writable or operation & fcntl.LOCK_SH):
            raise OSError(errno.EBADF, os.strerror(errno.EBADF))
        local(descriptor, operation)

    monkeypatch.setattr(fcntl, "flock", flock)
    with only_writer(tmp_path / "run"):
        assert is_held(tmp_path / "run")
        with pytest.raises(UserError, match="another process"), only_writer(tmp_path / "run"):
            pass
    assert not is_held(tmp_path / "run")


def test_whoever_waited_for_a_lock_that_is_gone_does_not_hold(tmp_path):
    with only_writer(tmp_path):
        waiting = os.open(tmp_path / ".lock", os.O_RDWR)
    with only_writer(tmp_path):
        assert not files.take(waiting, tmp_path / ".lock")
    assert not files.take(waiting, tmp_path / ".lock")
    os.close(waiting)


def test_a_file_system_without_locks_is_named(tmp_path, monkeypatch):
    def flock(*_):
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(fcntl, "flock", flock)
    with (
        pytest.raises(UserError, match="cannot be locked: No locks available"),
        only_writer(tmp_path),
    ):
        pass


def test_a_folder_is_replaced_by_one_at_a_time(tmp_path):
    with replacing_folder(tmp_path / "page") as new:
        (new / "first").touch()
        with pytest.raises(UserError, match="another process"), replacing_folder(tmp_path / "page"):
            pass
        (new / "second").touch()
    assert set(os.listdir(tmp_path / "page")) == {"first", "second"}
    with (
        only_writer(tmp_path / "page"),
        pytest.raises(UserError, match="another process"),
        replacing_folder(tmp_path / "page"),
    ):
        pass
    assert os.listdir(tmp_path) == ["page"]


def test_the_folder_of_the_command_is_not_replaced(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with (
        pytest.raises(UserError, match=r"^\. is where the command runs"),
        replacing_folder(Path()),
    ):
        pass
    assert not list(tmp_path.iterdir())
