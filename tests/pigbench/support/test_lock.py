import fcntl
import os
import subprocess
import sys
import threading

import pytest

from pigbench.errors import UserError
from pigbench.support.lock import is_held, only_writer

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
    process = subprocess.Popen(
        [sys.executable, "-P", "-c", HOLD, tmp_path / "run"], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "held\n"
    yield process
    process.kill()
    process.wait()


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
    with only_writer(tmp_path / "run"):
        assert is_held(tmp_path / "run")


def test_what_is_not_there_is_not_held(tmp_path):
    assert not is_held(tmp_path / "nothing")


def test_one_who_asks_keeps_nobody_out(tmp_path):
    descriptor = os.open(tmp_path, os.O_RDONLY)
    fcntl.flock(descriptor, fcntl.LOCK_SH)  # as is_held does, for a moment
    assert not is_held(tmp_path)
    threading.Timer(0.03, os.close, [descriptor]).start()
    with only_writer(tmp_path):
        pass


def test_a_file_is_no_folder(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="is not a folder"), only_writer(tmp_path / "file"):
        pass
