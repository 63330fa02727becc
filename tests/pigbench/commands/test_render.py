"""The commands that draw, on scenes and data small enough to test."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pigbench import cli, envs
from pigbench.data.writer import Writer
from pigbench.errors import UserError

SMALL = ["--size.width", "64", "--size.height", "48"]


@pytest.fixture
def data(tmp_path, spec, arrays) -> Path:
    """Episodes of 4 rows of random poses, the second shard one episode short."""
    env = envs.make("cube-single")
    writer = Writer(tmp_path / "data", dataclasses.replace(spec, layout=env.layout))
    generator = np.random.default_rng(0)
    for part in writer.missing():
        dropped = int(part.name == "train-00001")
        content = arrays(spec, part, dropped=dropped)
        rows = len(content["terminals"])
        content["observations"] = generator.normal(size=(rows, 28)).astype(np.float32)
        noise = generator.normal(scale=0.1, size=(rows, 21))
        content["qpos"] = (env.scene.home_qpos + noise).astype(np.float32)
        writer.write(part, content, dropped=dropped)
    return tmp_path / "data"


def test_a_tasks_scene(drawing, tmp_path):
    seen = []
    for task in ("1", "5"):
        path = tmp_path / f"{task}.png"
        cli.run(["render", "cube-single", "--task", task, "--out", str(path), *SMALL])
        seen.append(np.asarray(Image.open(path)))
    assert seen[0].shape[:2] == (48, 64)
    assert seen[0].std() > 1
    assert not np.array_equal(*seen)


def test_an_episode_of_a_data_set(drawing, data, tmp_path):
    av = pytest.importorskip("av")
    path = tmp_path / "play.mp4"
    cli.run(["data", "render", str(data), "--episode", "3", "--out", str(path), *SMALL])
    with av.open(path) as film:
        frames = list(film.decode(video=0))
    assert len(frames) == 4
    assert (frames[0].width, frames[0].height) == (64, 48)


WRONG = {
    "unknown source": (["cube-singel", "--out", "x.png"], "mean 'cube-single'"),
    "unknown task": (["cube-single", "--out", "x.png", "--task", "6"], "tasks 1 to 5"),
    "film of a scene": (["cube-single", "--out", "x.mp4"], r"does not end in \.png"),
    "no run": ([".", "--out", "x.mp4"], "is not a run"),
    "odd size": (["cube-single", "--out", "x.png", "--size.width", "63"], "even number"),
    "huge size": (["cube-single", "--out", "x.png", "--size.width", "99998"], "from 2 to 8192"),
    "episodes of a picture": (
        ["cube-single", "--out", "x.png", "--episodes", "1"],
        "episodes has no effect on an environment's picture: leave it out",
    ),
    "checkpoint of a picture": (
        ["cube-single", "--out", "x.png", "--checkpoint", "last"],
        "checkpoint has no effect on an environment's picture: leave it out",
    ),
    "environment of a file": (["cube-mine", "--out", "x.png"], "add --plugin FILE"),
}


@pytest.mark.parametrize(("arguments", "says"), WRONG.values(), ids=WRONG)
def test_bad_input_is_named(arguments, says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UserError, match=says):
        cli.run(["render", *arguments])
    assert not list(tmp_path.iterdir())
