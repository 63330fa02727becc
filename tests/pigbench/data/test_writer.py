import dataclasses
import os
import subprocess
import sys
from pathlib import Path
from unittest.mock import Mock

import pytest

from pigbench import cli
from pigbench.data import manifest, shard
from pigbench.data.dataset import load, verify
from pigbench.data.writer import Writer
from pigbench.errors import UserError
from pigbench.suite.status import is_complete
from pigbench.support import files


def contents(folder):
    paths = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder): path.read_bytes() for path in paths}


def test_a_kill_at_any_access_to_the_disk_ends_in_the_same_bytes(tmp_path):
    script = Path(__file__).with_name("kill_writer.py")
    command = [sys.executable, str(script), str(tmp_path)]
    finished = subprocess.run(command, capture_output=True, text=True, check=False)
    assert finished.returncode == 0, finished.stderr
    assert int(finished.stdout) > 50


def test_the_order_of_writing_leaves_no_trace(tmp_path, data, spec, arrays):
    writer = Writer(tmp_path / "turned", spec)
    for part in reversed(writer.missing()):
        writer.write(part, arrays(spec, part))
    assert contents(tmp_path / "turned") == contents(data)


def test_a_complete_data_set_has_nothing_missing_and_is_left_alone(data, spec):
    before = {path: path.stat().st_mtime_ns for path in data.rglob("*")}
    assert Writer(data, spec).missing() == ()
    assert {path: path.stat().st_mtime_ns for path in data.rglob("*")} == before


def test_leftovers_are_removed_and_other_files_kept(tmp_path, spec, arrays):
    first, second, *_ = Writer(tmp_path / "data", spec).missing()
    writer = Writer(tmp_path / "data", spec)
    writer.write(first, arrays(spec, first))
    (tmp_path / "data" / second.name).mkdir()
    files.temporary_path(tmp_path / "data" / second.name).mkdir()
    (tmp_path / "data" / "notes.txt").touch()
    assert Writer(tmp_path / "data", spec).missing() == spec.plan()[1:]
    assert set(os.listdir(tmp_path / "data")) == {"manifest.json", "notes.txt", first.name}


def test_lost_or_torn_shards_are_written_again(data, spec, arrays):
    expected = contents(data)
    (data / "train-00001" / "qpos.npy").unlink()
    os.truncate(data / "val-00000" / "actions.npy", 100)
    with pytest.raises(UserError, match="to mend it"):
        load(data)
    writer = Writer(data, spec)
    assert [part.name for part in writer.missing()] == ["train-00001", "val-00000"]
    for part in writer.missing():
        writer.write(part, arrays(spec, part))
    assert contents(data) == expected
    assert verify(data) == []


def test_another_specification_is_refused_with_the_field(data, spec):
    changed = dataclasses.replace(spec, versions=spec.versions | {"mujoco": "1.1"})
    with pytest.raises(UserError, match=r"versions\.mujoco is '1\.0' there and '1\.1' now"):
        Writer(data, changed)


def test_a_folder_of_something_else_is_refused_untouched(tmp_path, spec):
    (tmp_path / "train-00000").mkdir()
    with pytest.raises(UserError, match="is not an empty folder and holds no data set"):
        Writer(tmp_path, spec)
    assert os.listdir(tmp_path) == ["train-00000"]


def test_a_full_disk_keeps_the_finished_shards(tmp_path, monkeypatch, spec, arrays):
    writer = Writer(tmp_path / "data", spec)
    first, second, *_ = writer.missing()
    writer.write(first, arrays(spec, first))

    def open_full_device(*_):
        return open("/dev/full", "wb")

    monkeypatch.setattr(shard, "open", open_full_device, raising=False)
    with pytest.raises(UserError, match="no space left on device"):
        writer.write(second, arrays(spec, second))
    assert [part.name for part in manifest.read(tmp_path / "data").shards] == [first.name]
    assert set(os.listdir(tmp_path / "data")) == {"manifest.json", "shards.jsonl", first.name}


def test_a_kill_before_the_last_manifest_leaves_no_data_set_whose_digest_would_change(
    tmp_path, monkeypatch, data, spec, arrays
):
    folder = tmp_path / "killed"
    writer = Writer(folder, spec)
    first, *others = writer.missing()
    writer.write(first, arrays(spec, first))
    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(manifest, "write", raising := Mock(side_effect=KeyboardInterrupt))
        for part in others:
            writer.write(part, arrays(spec, part))
    raising.assert_called_once()  # all shards were there
    unfinished = r"killed is unfinished: shards\.jsonl is still to be taken into manifest\.json"
    with pytest.raises(UserError, match=rf"{unfinished}; run the same `pigbench generate` again"):
        load(folder)
    assert not is_complete(folder)
    with pytest.raises(UserError, match=unfinished):
        cli.run(["data", "push", "someone/something", "--data", str(folder)])
    (problem,) = verify(folder)
    assert "is unfinished" in problem
    assert Writer(folder, spec).missing() == ()
    assert is_complete(folder)
    assert contents(folder) == contents(data)


def test_a_shard_costs_a_line_until_all_are_there(tmp_path, spec, arrays):
    folder = tmp_path / "data"
    writer = Writer(folder, spec)
    first, second, *others = writer.missing()
    before = (folder / "manifest.json").read_bytes()
    for part in (first, second):
        writer.write(part, arrays(spec, part))
    assert (folder / "manifest.json").read_bytes() == before
    journal = folder / "shards.jsonl"
    lines = journal.read_text().splitlines(keepends=True)
    journal.write_text(lines[0] + lines[1][:20])  # as a crash of the machine may leave it
    assert [part.name for part in manifest.read(folder).shards] == [first.name]
    writer = Writer(folder, spec)
    for part in (second, *others):
        writer.write(part, arrays(spec, part))
    assert not journal.exists()
    assert verify(folder) == []
