"""Each tracker's own files, read back: the same numbers under the same names, and films."""

import io
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from tensorboardX.proto.event_pb2 import Event

from pigbench import cli, trackers
from pigbench.errors import UserError
from pigbench.evaluation.episodes import Episode
from pigbench.runs import run as runs
from pigbench.support import pictures
from pigbench.trackers import Tracker
from pigbench.trackers.tensorboard import TensorBoard

PLUGIN = """
from pigbench import trackers

class Printed(trackers.Tracker):
    def scalars(self, step, values):
        print(step, values)

trackers.register("printed", Printed)
"""


@pytest.fixture
def run(make_run, tmp_path) -> runs.Run:
    return make_run(tmp_path / "run", {0: [[0, 1]]})


@pytest.fixture
def film(tmp_path) -> Path:
    pytest.importorskip("av")
    frames = (np.full((24, 32, 3), 6 * number, np.uint8) for number in range(40))
    pictures.write_mp4(tmp_path / "film.mp4", frames, rate=20)
    return tmp_path / "film.mp4"


def test_evaluations_have_their_names():
    rows = [
        Episode(
            5, task, f"task{task}_x", 0, 7, "mujoco", {"success": task == 2, "nearest": 0.1 * task}
        )
        for task in (1, 2)
    ]
    rows.append(Episode(5, 2, "task2_x", 1, 7, "mujoco", {"success": False}))
    assert trackers.evaluated(rows) == pytest.approx(
        {
            "evaluation/success": 1 / 3,
            "evaluation/nearest": 0.15,
            "evaluation/task1_x/success": 0.0,
            "evaluation/task2_x/success": 0.5,
        }
    )


def records(content: bytes):
    """Of a file of TensorBoard: length (8 bytes), its checksum (4), the event, its checksum (4)."""
    while content:
        length = int.from_bytes(content[:8], "little")
        yield Event.FromString(content[12 : 12 + length])
        content = content[16 + length :]


def test_tensorboard(run, film):
    with TensorBoard(run, step=20) as tracker:
        tracker.scalars(30, {"loss": 0.25, "evaluation/success": 0.5})
        tracker.film(30, "evaluation/film/task1_x/success", film)
    (path,) = (run.path / "tensorboard").iterdir()
    events = list(records(path.read_bytes()))
    values = [(event.step, value) for event in events for value in event.summary.value]
    *scalars, (step, picture) = values
    assert [(step, v.tag, v.simple_value) for step, v in scalars] == [
        (30, "loss", 0.25),
        (30, "evaluation/success", 0.5),
    ]
    assert 21 in [event.step for event in events if event.HasField("session_log")]
    assert (step, picture.tag) == (30, "evaluation/film/task1_x/success")
    gif = Image.open(io.BytesIO(picture.image.encoded_image_string))
    assert (gif.n_frames, gif.info["duration"], gif.size) == (10, 200, (160, 120))
    gif.seek(9)
    assert np.abs(np.asarray(gif.convert("RGB")).mean() - 6 * 36) < 5


def history(path: Path) -> list[dict[str, str]]:
    """The rows in a file of W&B: chunks in blocks of 32 KiB, as LevelDB's log has them."""
    from wandb.proto.wandb_internal_pb2 import Record

    content, place, rows, record = path.read_bytes(), 7, [], b""
    while place + 7 < len(content):
        if 32768 - place % 32768 < 7:  # no header fits in the rest of a block
            place += 32768 - place % 32768
            continue
        length, kind = int.from_bytes(content[place + 4 : place + 6], "little"), content[place + 6]
        record += content[place + 7 : place + 7 + length]
        place += 7 + length
        if kind in (1, 4):  # whole, or its last part
            items = Record.FromString(record).history.item
            if items:
                rows.append({i.key or "/".join(i.nested_key): i.value_json for i in items})
            record = b""
    return rows


def written(path: Path, *, seconds: float = 20) -> list[dict[str, str]]:
    """The rows in a file of W&B, whose own process may write the last ones after it was let go."""
    deadline = time.monotonic() + seconds
    while not (rows := history(path)) and time.monotonic() < deadline:
        time.sleep(0.1)
    return rows


def test_wandb_offline(run, make_run, tmp_path, film, monkeypatch):
    pytest.importorskip("wandb")
    monkeypatch.setenv("WANDB_MODE", "offline")
    tracker = trackers.get("wandb")
    other = make_run(tmp_path / "other", {0: [[0, 1]]}, seed=1)
    with tracker(run, step=0) as one, tracker(other, step=0) as two:
        one.scalars(10, {"loss": 0.25, "evaluation/success": 0.5})
        two.scalars(10, {"loss": 4.0})
        one.film(10, "evaluation/film/task1_x/success", film)
    with tracker(run, step=0) as again:
        again.scalars(10, {"loss": 0.75})
    first, second = sorted((run.path / "wandb").glob("offline-run-*/*.wandb"))
    assert first.name == second.name, "W&B is to know it for the same run"
    numbers, picture = history(first)
    assert (numbers["step"], numbers["loss"], numbers["evaluation/success"]) == (
        "10",
        "0.25",
        "0.5",
    )
    assert picture["step"] == "10"
    assert picture["evaluation/film/task1_x/success/_type"] == '"video-file"'
    assert [row["loss"] for row in written(second)] == ["0.75"]
    (beside,) = (other.path / "wandb").glob("offline-run-*/*.wandb")
    assert [row["loss"] for row in history(beside)] == ["4"]
    (copy,) = first.parent.glob("files/media/**/*.mp4")
    assert copy.read_bytes() == film.read_bytes()


def test_trackio(run, make_run, tmp_path, film, monkeypatch):
    monkeypatch.setenv("TRACKIO_DIR", str(tmp_path / "trackio"))  # read as it is imported
    assert "trackio" not in sys.modules
    pytest.importorskip("trackio")
    from trackio.sqlite_storage import SQLiteStorage

    tracker = trackers.get("trackio")
    other = make_run(tmp_path / "other", {0: [[0, 1]]}, seed=1)
    with tracker(run, step=0) as one, tracker(other, step=0) as two:
        one.scalars(10, {"loss": 0.25, "evaluation/success": 0.5})
        two.scalars(10, {"loss": 4.0})
        one.film(10, "evaluation/film/task1_x/success", film)
    with tracker(run, step=10) as again:
        again.scalars(20, {"loss": 0.75})
    numbers, picture, later = SQLiteStorage.get_logs("pigbench", one.name)
    assert (numbers["step"], numbers["loss"], numbers["evaluation/success"]) == (10, 0.25, 0.5)
    assert picture["evaluation/film/task1_x/success"]["_type"] == "trackio.video"
    assert (later["step"], later["loss"]) == (20, 0.75)
    (beside,) = SQLiteStorage.get_logs("pigbench", two.name)
    assert beside["loss"] == 4.0


def test_a_logger_of_ones_own_is_a_class(tmp_path):
    (tmp_path / "plugin.py").write_text(PLUGIN)
    train = ["train", "gcbc", "--data", "d", "--out", "o", "--preset", "cpu", "--logger"]
    command = cli.parse([*train, "printed", "tensorboard", "--plugin", str(tmp_path / "plugin.py")])
    assert command.logger == ("printed", "tensorboard")
    assert issubclass(trackers.get("printed"), Tracker)
    with pytest.raises(UserError, match="logger 'printed' is already registered"):
        trackers.register("printed", TensorBoard)
    with pytest.raises(UserError, match="unknown logger 'wandbb': did you mean 'wandb'"):
        cli.parse([*train, "wandbb"])


def test_one_that_is_not_installed_is_named(monkeypatch):
    for name in ("wandb", "pigbench.trackers.wandb"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.setattr(trackers.registry, "_TRACKERS", {})
    monkeypatch.setitem(sys.modules, "wandb", None)
    with pytest.raises(
        UserError, match=r"needs the package wandb: pip install 'pigbench\[wandb\]'"
    ):
        trackers.get("wandb")
