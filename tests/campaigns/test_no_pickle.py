"""No command runs code that a file holds: nothing is unpickled, whatever takes a file's place."""

import dataclasses
import io
import os
import pickle
import shlex
import shutil
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from pigbench import cli
from pigbench.data import manifest
from pigbench.data.manifest import FileRecord

MARK = "unpickled"
IMPORT = "data import F.npz --environment cube-single --out OUT"
READERS = {
    "DATA": ["data info DATA", "data verify DATA", "data export DATA --out OUT.npz"],
    "RUN": ["table RUN", "suite status RUN", "analyze RUN --data NONE"],
}
"""What reads all that there is, soon: `analyze` takes a run's parts together, then misses NONE."""
LONG_READERS = {
    "DATA": [
        "train gcbc --data DATA --out OUT",
        "train gcbc --data DATA --out OUT --rows disk",
        "data render DATA --out OUT.mp4",
        "analyze RUN --data DATA --out OUT",
        "generate cube-single --out DATA",
    ],
    "RUN": [
        "plot RUN --out OUT.png",
        "evaluate RUN",
        "render RUN --out OUT.mp4",
        "train gcbc --data DATA --out RUN",
    ],
}
"""Further ones, which the whole campaign runs too."""


class Hostile:
    """What makes a folder `MARK` here when it is unpickled."""

    def __reduce__(self):
        return os.mkdir, (MARK,)


def as_array() -> bytes:
    file = io.BytesIO()
    np.save(file, np.array([Hostile()] * 11), allow_pickle=True)
    return file.getvalue()


def put(path: Path, content: bytes) -> None:
    """In the place of a file, in a manifest's records too."""
    path.write_bytes(content)
    folder = path.parents[1]
    if path.suffix == ".npy" and (folder / manifest.FILE_NAME).exists():
        whole = manifest.read(folder)
        records = [
            dataclasses.replace(one, files={**one.files, path.name: FileRecord.of(path)})
            if one.name == path.parent.name
            else one
            for one in whole.shards
        ]
        manifest.write(folder, whole.with_shards(records))


def opened(command: str, monkeypatch) -> int | None:
    """The exit status, after whatever the command did with what it read."""
    monkeypatch.setattr(sys, "argv", ["pigbench", *shlex.split(command)])
    try:
        cli.main()
    except SystemExit as stop:
        return stop.code
    return None


def test_the_trap_works(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    np.load(io.BytesIO(as_array()), allow_pickle=True)
    assert Path(MARK).is_dir()


@pytest.mark.parametrize("folder", READERS)
def test_no_file_of_a_folder_is_unpickled(folder, place, monkeypatch, whole_campaign):
    """Each file in turn is a pickle, or an array of objects; all commands then look at it."""
    names = [
        path.relative_to(place)
        for path in sorted((place / folder).rglob("*"))
        if path.is_file() and "tensorboard" not in path.parts
    ]
    hostile = {".npy": as_array()}
    # A kind of file is read by one function: one of each will do where time is short.
    kinds = {name.suffix or name.parent.name: name for name in names}
    for name in names if whole_campaign else kinds.values():
        shutil.copytree(place / folder, place / "before")
        put(place / name, hostile.get(name.suffix, pickle.dumps(Hostile())))
        for command in READERS[folder] + LONG_READERS[folder] * whole_campaign:
            opened(command, monkeypatch)
            assert not Path(MARK).exists(), f"{command} unpickled {name}"
        shutil.rmtree(place / folder)
        (place / "before").rename(place / folder)


@pytest.mark.parametrize("field", ["observations", "actions", "terminals", "qpos"])
def test_no_archive_of_arrays_is_unpickled(field, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    arrays = {
        "observations": np.zeros((11, 28), np.float32),
        "actions": np.zeros((11, 5), np.float32),
        "terminals": np.arange(11) == 10,
    }
    np.savez("F.npz", **{**arrays, field: np.array([Hostile()] * 11)})
    assert opened(IMPORT, monkeypatch) == 2
    assert not Path(MARK).exists()
    (line,) = [line for line in capsys.readouterr().err.splitlines() if " %  " not in line]
    assert line.startswith("pigbench: F.npz ")


def test_no_archive_is_a_pickle(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("F.npz").write_bytes(pickle.dumps(Hostile()))
    assert opened(IMPORT, monkeypatch) == 2
    with zipfile.ZipFile("F.npz", "w") as archive:
        for name in ("observations", "actions", "terminals"):
            archive.writestr(f"{name}.npy", pickle.dumps(Hostile()))
    assert opened(IMPORT, monkeypatch) == 2
    assert not Path(MARK).exists()


@pytest.mark.parametrize("command", ["suite F.toml --out OUT", "suite status SUITE"])
def test_no_suite_is_a_pickle(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("SUITE").mkdir()
    for name in ("F.toml", "SUITE/suite.json"):
        Path(name).write_bytes(pickle.dumps(Hostile()))
    assert opened(command, monkeypatch) == 2
    assert not Path(MARK).exists()
