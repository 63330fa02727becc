"""Killed at random moments and run again, a command ends with what an unbroken one ends with.

`make test` kills an import twice; `PIGBENCH_CAMPAIGN=all` kills everything 50 times, or as often as
PIGBENCH_KILLS says. Every moment is printed, with what came of it.
"""

import json
import os
import random
import shutil
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import jax
import numpy as np
import orbax.checkpoint as ocp
import pytest

from pigbench.data import dataset, ogbench

IN_A_ROW = 5  # kills, before a command may come to its end
ALL = os.environ.get("PIGBENCH_CAMPAIGN") == "all"
KILLS = int(os.environ.get("PIGBENCH_KILLS", 50)) if ALL else 2

SMALL = "--preset cpu --agent.batch-size 8 --agent.actor-hidden-sizes 8"
STEPS = "--steps 60 --log-every 10 --evaluate-every 20 --evaluation.episodes 1"
VALUE = "--agent.value-hidden-sizes 8"
LOW = "--agent.low.actor-hidden-sizes 8 --agent.low.value-hidden-sizes 8"
SUITE = """
preset = "cpu"
methods = ["gcbc"]
seeds = [0, 1]
evaluation = {every = 20, episodes = 1}
agent = {batch_size = 8, actor_hidden_sizes = [8]}
environments = [{name = "cube-single", transitions = 20, steps = 40, data = "DATA"}]
"""


def archives() -> None:
    """Files of OGBench's, several: an import writes them shard by shard."""
    Path("FILES").mkdir()
    for number in range(6):
        ogbench.write(dataset.load(Path("DATA")), Path(f"FILES/{number}.npz"))


def suite_file() -> None:
    Path("SUITE.toml").write_text(SUITE)


class Subject(NamedTuple):
    """A command that writes the folder OUT, and what it needs first."""

    command: str
    before: Callable[[], object] = lambda: None  # once
    each: Callable[[], object] = lambda: None  # before every attempt at the whole


SUBJECTS = {
    "import": Subject("data import FILES --environment cube-single --out OUT", archives),
    "generation": Subject(
        "generate cube-single --out OUT --episodes 6 --episodes-per-shard 1 "
        "--validation-episodes 1 --episode-length 21"
    ),
    "training, rows on the device": Subject(f"train gcbc --data DATA --out OUT {SMALL} {STEPS}"),
    "training, rows on the disk": Subject(
        f"train gcbc --data DATA --out OUT {SMALL} {STEPS} --rows disk"
    ),
    "hierarchy": Subject(
        "train h-flow-gcivl --data DATA --out OUT --agent.candidates 2 "
        f"{SMALL} {VALUE} {LOW} {STEPS}"
    ),
    "suite of two workers": Subject("suite SUITE.toml --out OUT --jobs 2", suite_file),
    "evaluation": Subject(
        "evaluate OUT --episodes 2 --seed 5", each=lambda: shutil.copytree("RUN", "OUT")
    ),
}
CHOSEN = SUBJECTS if ALL else ["import"]

NOT_COMPARED = {"tensorboard", "logs", "checkpoints"}  # checkpoints by their numbers, below
DRAWN = {".png", ".pdf"}


def results(folder: Path) -> dict[str, bytes]:
    """What every file holds, and the numbers of every last checkpoint."""
    found = {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and not NOT_COMPARED & {*path.parts} and path.suffix not in DRAWN
    }
    for kept in folder.rglob("checkpoints"):
        last = max(int(path.name) for path in kept.iterdir() if path.name.isdigit())
        state = ocp.StandardCheckpointer().restore(kept.absolute() / str(last) / "default")
        numbers = [np.asarray(leaf).tobytes() for leaf in jax.tree.leaves(state)]
        found[f"{kept.relative_to(folder)}/{last}"] = b"".join(numbers)
    return found


def kill(process: int, *, all_of_them: bool) -> None:
    """The process, or those that it has started too."""
    (os.killpg if all_of_them else os.kill)(process, signal.SIGKILL)


@pytest.mark.parametrize("name", CHOSEN)
def test_killed_and_run_again(name, place, server, capsys):
    subject = SUBJECTS[name]
    log, out = place / "LOG", place / "OUT"
    draws = random.Random(name)

    def say(**what: object) -> None:
        with capsys.disabled():
            print(json.dumps({"command": name, **what}), flush=True)

    subject.before()
    subject.each()
    server.run(subject.command, log)  # compiles, for the next ones to be as fast as each other
    expected = results(out)
    shutil.rmtree(out)
    subject.each()
    began = time.monotonic()
    assert server.run(subject.command, log) == 0, log.read_text()
    unbroken = time.monotonic() - began
    assert results(out) == expected
    for number in range(1, KILLS + 1):
        if number % IN_A_ROW == 1:
            shutil.rmtree(out)
            subject.each()
        moment = draws.uniform(0, unbroken)
        process = server.start(subject.command, log)
        time.sleep(moment)
        kill(process, all_of_them=draws.random() < 0.5)
        was_killed = server.wait(process) == -signal.SIGKILL
        say(kill=number, moment=round(moment, 2), of=round(unbroken, 2), was_killed=was_killed)
        if number % IN_A_ROW == 0 or number == KILLS:
            assert server.run(subject.command, log) == 0, log.read_text()
            assert results(out) == expected
            say(kills=number, ended="with the bytes of an unbroken run")
    assert "Traceback" not in log.read_text()
