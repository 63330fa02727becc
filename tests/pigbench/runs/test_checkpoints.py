"""A disk that is full while a checkpoint is written: one line, and what was there stays."""

import contextlib
import re
import shutil
import subprocess
from collections import namedtuple
from pathlib import Path

import jax
import jax.numpy as jnp
import pytest

from pigbench.agents import TrainState
from pigbench.errors import UserError
from pigbench.runs.checkpoints import Checkpoints
from pigbench.support import files

Usage = namedtuple("Usage", "total used free")
LARGE = 1_000_000


def state(step: int, size: int = 10) -> TrainState:
    params = {"a": jax.random.normal(jax.random.key(0), (size,))}
    return TrainState(params, {}, (), jnp.array(step), {})


@pytest.fixture
def small_disk(tmp_path):
    """Two megabytes, where this user may mount."""
    folder = tmp_path / "small"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=2m", "none", folder]
    if shutil.which("mount") is None or subprocess.run(command, capture_output=True).returncode:
        pytest.skip("no file system can be mounted here")
    yield folder
    subprocess.run(["umount", "--lazy", folder], check=True)


def test_room_is_asked_for_first(tmp_path, monkeypatch, capfd):
    with Checkpoints(tmp_path) as checkpoints:
        checkpoints.save(state(1))
        monkeypatch.setattr(shutil, "disk_usage", lambda _: Usage(2000, 2000, 39))
        with pytest.raises(UserError, match=r"needs .* GB more"):
            checkpoints.save(state(2))
        assert checkpoints.steps() == [1]
    assert capfd.readouterr().err == ""
    assert {path.name for path in tmp_path.iterdir()} == {"1"}


def test_the_last_two_are_those_of_the_last_steps_in_whatever_order_they_were_saved(tmp_path):
    with Checkpoints(tmp_path) as checkpoints:
        for step in (15, 20, 0, 5):
            checkpoints.save(state(step))
        assert checkpoints.steps() == [15, 20]


@pytest.mark.parametrize("time", ["1e400", '"now"', "1" + "0" * 30])
def test_a_record_that_is_altered(tmp_path, time):
    """Orbax reads it before a step is asked for, and names none in what it raises."""
    with Checkpoints(tmp_path) as checkpoints:
        for step in (1, 2):
            checkpoints.save(state(step))
    record = tmp_path / "1" / "_CHECKPOINT_METADATA"
    altered = re.sub(r'("commit_timestamp_nsecs": )\d+', rf"\g<1>{time}", record.read_text())
    assert altered != record.read_text()
    record.write_text(altered)
    with pytest.raises(UserError, match=rf"{tmp_path}/1 cannot be read"):
        Checkpoints(tmp_path).restore(state(1), 1)


def test_a_disk_that_fills_up_meanwhile(small_disk: Path, monkeypatch, caplog):
    monkeypatch.setattr(files, "require_room", lambda *_: None)
    with Checkpoints(small_disk / "run") as checkpoints:
        checkpoints.save(state(1))
        with pytest.raises(UserError, match="no space left on device"):
            checkpoints.save(state(2, LARGE))
        assert not caplog.records
    with Checkpoints(small_disk / "run") as again, contextlib.suppress(UserError):
        again.restore(state(0), 1)
        assert again.steps() == [1]


def test_reading_makes_and_tidies_nothing_and_says_nothing(tmp_path, caplog):
    with Checkpoints(tmp_path / "run") as checkpoints:
        checkpoints.save(state(1))
    left = tmp_path / "run" / "2.orbax-checkpoint-tmp"
    left.mkdir()
    with Checkpoints(tmp_path / "run", read_only=True) as reading:
        assert reading.steps() == [1]
        reading.restore(state(0), 1)
    assert not caplog.records
    assert left.is_dir()
    with Checkpoints(tmp_path / "none", read_only=True) as nothing:
        assert nothing.steps() == []
    assert not (tmp_path / "none").exists()
