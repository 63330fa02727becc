"""A byte that is flipped anywhere is found, and its file named; or it changes nothing that is read.

`make test` flips some bytes of every file; `PIGBENCH_CAMPAIGN=all` flips all, but of checkpoints,
whose reading takes long, 3,000.
"""

import functools
import json
import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np
import pytest

from pigbench.agents import TrainState
from pigbench.data import dataset, manifest
from pigbench.errors import UserError
from pigbench.evaluation import episodes
from pigbench.runs import run
from pigbench.runs.checkpoints import Checkpoints
from pigbench.runs.restore import restore
from pigbench.runs.statistics import read_statistics
from pigbench.suite import spec

SUITE = """
methods = ["gcbc", "h-flow-gcivl"]
seeds = [0, 3]
variants.fast.learning_rate = 1e-3
evaluation.every = 5_000
environments = [{name = "cube-single", transitions = 1_500, steps = 20_000}]
"""


class Case(NamedTuple):
    """Files, and what reads them: the same from unaltered ones, UserError from others."""

    files: Callable[[Path], Iterator[Path]]
    read: Callable[[Path], Any]
    few: int  # flips for `make test`
    many: int = 10**9


def verified(folder: Path) -> Any:
    """All that a data set says and holds."""
    problems = dataset.verify(folder / "DATA")
    if problems:
        raise UserError(problems[0])
    return manifest.read(folder / "DATA")


@functools.cache
def like(folder: Path) -> TrainState:
    return restore(folder / "RUN").state


def trained(folder: Path) -> Any:
    """A checkpoint's numbers."""
    structure = like(folder)  # of the unaltered one: it is read first
    with Checkpoints(folder / "RUN/checkpoints", read_only=True) as checkpoints:
        state = checkpoints.restore(structure, 1)
    return [np.asarray(leaf).tobytes() for leaf in jax.tree.leaves(state)]


def statistics(folder: Path) -> Any:
    return [values.tolist() for values in read_statistics(folder / "RUN/statistics.json")]


def below(name: str) -> Callable[[Path], Iterator[Path]]:
    return lambda folder: (path for path in sorted((folder / name).rglob("*")) if path.is_file())


def one(name: str) -> Callable[[Path], Iterator[Path]]:
    return lambda folder: iter([folder / name])


CASES = {
    "data set": Case(below("DATA"), verified, few=300),
    "unfinished data set": Case(
        one(f"BEGUN/{manifest.JOURNAL}"), lambda folder: manifest.read(folder / "BEGUN"), few=100
    ),
    "checkpoint": Case(below("RUN/checkpoints/1"), trained, few=60, many=3000),
    "episodes": Case(
        one("RUN/episodes.csv"), lambda folder: episodes.read(folder / "RUN/episodes.csv"), few=300
    ),
    "configuration": Case(
        one("RUN/config.json"), lambda folder: run.read_run(folder / "RUN").config, few=200
    ),
    "statistics": Case(one("RUN/statistics.json"), statistics, few=200),
    "suite": Case(one("suite.json"), lambda folder: spec.read_kept(folder / "suite.json"), few=200),
}


@pytest.fixture
def with_suite(place) -> Path:
    """The same, with a suite's state, and data that are being written."""
    (place / "suite.toml").write_text(SUITE)
    spec.write(place / "suite.json", spec.read(place / "suite.toml"))
    whole = manifest.read(place / "DATA")
    (place / "BEGUN").mkdir()
    manifest.write(place / "BEGUN", manifest.Manifest(whole.spec, ()))
    for record in whole.shards:
        manifest.add(place / "BEGUN", record)
    return place


def flips(files: list[Path], count: int) -> Iterator[tuple[Path, int, int]]:
    """Files, places in them, and what to flip there: all places, or as many, some in each file."""
    draws = random.Random(0)
    for path in files:
        size = path.stat().st_size
        own = max(1, count // len(files))
        places = range(size) if own >= size else sorted(draws.sample(range(size), own))
        yield from ((path, place, draws.randrange(1, 256)) for place in places)


@pytest.mark.parametrize("name", CASES)
def test_it_is_found_or_harmless(name, with_suite, whole_campaign, capsys):
    place = with_suite
    case = CASES[name]
    files = [path for path in case.files(place) if path.stat().st_size]
    expected = case.read(place)
    harmless = found = 0
    for path, where, mask in flips(files, case.many if whole_campaign else case.few):
        content = path.read_bytes()
        path.write_bytes(content[:where] + bytes([content[where] ^ mask]) + content[where + 1 :])
        what = f"byte {where} of {path.relative_to(place)}"
        try:
            assert case.read(place) == expected, f"{what} goes unnoticed"
            harmless += 1
        except UserError as error:
            message = str(error)
            named = [str(path), str(place / "RUN/checkpoints/1")]
            assert any(name in message for name in named), f"{what}: {message}"
            found += 1
        finally:
            path.write_bytes(content)
    assert case.read(place) == expected
    assert found
    with capsys.disabled():
        print(json.dumps({"case": name, "found": found, "harmless": harmless}))
