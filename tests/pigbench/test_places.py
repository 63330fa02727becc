"""Where a command cannot write, it says so in one line, before it reads or computes anything."""

import contextlib
import importlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from pigbench import cli
from pigbench.errors import UserError
from pigbench.support.lock import only_writer, replacing_folder

NOBODY = 65534

# What each command reads does not exist: were it read first, the complaint would be of that.
FOLDERS = {
    "generate": "generate cube-single --out {}",
    "data import": "data import nothing.npz --environment cube-single --out {}",
    "train": "train gcivl --data nothing --out {}",
    "train of several seeds": "train gcivl --data nothing --seeds 0 1 --out {}",
    "analyze": "analyze nothing --data nothing --out {}",
    "toy": "toy --out {}",
    "bench device": "bench device --out {}",
    "suite": "suite cpu-flat --out {}",
    "report": "report nothing --out {}",
}
FILES = {
    "render": "render cube-single --out {}.png",
    "film": "render . --out {}.mp4",
    "subgoals": "subgoals nothing --data nothing --out {}",
    "parity": "parity --json {}",
    "parity data": "parity data --json {}",
    "parity policy": "parity policy nothing --json {}",
    "bench rows": "bench rows --json {}",
    "bench startup": "bench startup --json {}",
    "bench train": "bench train --json {}",
    "bench generate": "bench generate --json {}",
    "bench evaluate": "bench evaluate --json {}",
    "bench scale": "bench scale --out {}.png",
    "bench scale's numbers": f"bench scale --out {tempfile.gettempdir()}/x.png --json {{}}",
}
EVERY = FOLDERS | FILES
# These read what there is to be written, or to be drawn, first: it is there, and small.
READING = {
    "data export": "data export {data} --out {out}.npz",
    "data render": "data render {data} --out {out}.mp4",
    "plot": "plot {run} --out {out}.png",
}


RUNNING = (
    "pigbench.analysis.figure",
    "pigbench.bench.device",
    "pigbench.data.remote",
    "pigbench.fidelity.tables",
    "pigbench.report.plots",
    "pigbench.toy.figures",
    "pigbench.training.train",
)
"""What commands import when they run, with all that it imports."""


@pytest.fixture(scope="module", autouse=True)
def imported() -> None:
    """Before one is a user who may not read Python's own modules, if they are in root's home."""
    for module in RUNNING:
        importlib.import_module(module)


@contextlib.contextmanager
def unprivileged() -> Iterator[None]:
    """As a user who may not write everywhere."""
    if os.geteuid() != 0:
        yield
        return
    os.seteuid(NOBODY)
    try:
        yield
    finally:
        os.seteuid(0)


@pytest.fixture
def open_folder() -> Iterator[Path]:
    """A folder that every user may enter."""
    with tempfile.TemporaryDirectory() as folder:
        os.chmod(folder, 0o755)
        yield Path(folder)


@pytest.fixture
def sealed(open_folder) -> Iterator[Path]:
    """A folder in which one may not write."""
    folder = open_folder / "sealed"
    folder.mkdir(mode=0o555)
    yield folder
    folder.chmod(0o755)


def refuse(command: str, place: object, says: str) -> None:
    parsed = cli.parse(command.format(place).split())
    with unprivileged(), pytest.raises(UserError, match=says):
        parsed.run()


@pytest.fixture
def inputs(open_folder, data, make_run) -> dict[str, Path]:
    run = make_run(open_folder / "run", {0: [[1]]})
    shutil.copytree(data, open_folder / "data")
    return {"data": open_folder / "data", "run": run.path}


@pytest.mark.parametrize("command", EVERY.values(), ids=EVERY)
def test_a_folder_that_one_may_not_write_is_named(command, sealed):
    refuse(command, sealed / "deep" / "out", f"cannot be written: .* in {sealed}")
    assert not list(sealed.iterdir())


@pytest.mark.parametrize("command", EVERY.values(), ids=EVERY)
def test_a_file_in_a_folders_way_is_named(command, open_folder):
    (open_folder / "file").touch()
    refuse(command, open_folder / "file" / "out", "file is not a folder")
    assert os.listdir(open_folder) == ["file"]


@pytest.mark.parametrize("command", FILES.values(), ids=FILES)
def test_a_folder_in_a_files_way_is_named(command, open_folder):
    for ending in ("", ".png", ".mp4"):
        (open_folder / f"out{ending}").mkdir()
    refuse(command, open_folder / "out", "out.* is not a file")


@pytest.mark.parametrize("command", READING.values(), ids=READING)
def test_what_is_written_of_what_is_there(command, inputs, sealed):
    parsed = cli.parse(command.format(**inputs, out=sealed / "out").split())
    with pytest.raises(UserError, match="cannot be written"), unprivileged():
        parsed.run()


@pytest.mark.parametrize("command", ["evaluate {}", "analyze {} --data nothing"])
def test_a_run_that_one_may_not_write_is_not_rolled_out(command, inputs):
    inputs["run"].chmod(0o555)
    refuse(command, inputs["run"], "cannot be written")


LOCKED = {name: FOLDERS[name] for name in ("generate", "toy", "suite", "bench device")} | {
    "evaluate": "evaluate {}",  # what imports, trains or analyses is tested where its inputs are
}


@pytest.mark.parametrize("command", LOCKED.values(), ids=LOCKED)
def test_a_folder_that_is_being_written_is_left_alone(command, inputs):
    parsed = cli.parse(command.format(inputs["run"]).split())
    with (
        only_writer(inputs["run"]),
        pytest.raises(UserError, match="is being written by another process"),
    ):
        parsed.run()


@pytest.mark.parametrize(
    "command",
    [
        "report {run}",
        "data export {data} --format minari",
        "data export {data} --format lerobot",
    ],
)
def test_a_folder_that_is_being_replaced_is_left_alone(command, inputs, tmp_path):
    for package in ("bokeh", "jinja2", "pyarrow"):
        pytest.importorskip(package)
    parsed = cli.parse([*command.format(**inputs).split(), "--out", str(tmp_path / "out")])
    with replacing_folder(tmp_path / "out") as new:
        (new / "file").touch()
        with pytest.raises(UserError, match="is being written by another process"):
            parsed.run()
    assert os.listdir(tmp_path / "out") == ["file"]


@pytest.mark.parametrize("arguments", [["list", "envs"], ["train", "--help"], []])
def test_output_that_nobody_can_keep(arguments):
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-P", "-m", "pigbench", *arguments],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
        )
    assert (done.returncode, done.stderr) == (2, "pigbench: output: No space left on device\n")
