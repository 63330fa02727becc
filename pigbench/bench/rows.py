"""Training timed with rows in each of their homes, each in a process of its own."""

import dataclasses
import multiprocessing
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import jax
import numpy as np

from pigbench import agents, envs
from pigbench.agents import Statistics
from pigbench.bench.timing import Contender
from pigbench.data import collect, dataset, homes
from pigbench.data.defaults import EPISODE_ROWS
from pigbench.data.homes import Home
from pigbench.data.manifest import Shard, Spec
from pigbench.data.writer import Writer
from pigbench.envs.oracles import POLICIES
from pigbench.errors import UserError
from pigbench.support import files
from pigbench.support.progress import Progress
from pigbench.training import batches
from pigbench.training.provenance import package_versions
from pigbench.training.restore import agent_for
from pigbench.training.train import make_updates

_METHOD, _PRESET = "gcivl", "cpu"
_EPISODES_PER_SHARD, _SIMULATED = 50, 5  # a shard repeats the simulated episodes


class Trainer:
    """A process that trains on the data set in `folder`, with its rows in one home."""

    def __init__(self, folder: Path, home: str) -> None:
        self._home = home
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, folder, home), daemon=True)
        self._process.start()
        theirs.close()
        self.seconds_to_open: float = self._answer()

    def contender(self) -> Contender:
        """The process's updates; a unit is one update."""
        return Contender(self._home, self._ask)

    def resident(self) -> int:
        """Resident bytes of the process, excluding pages of files."""
        return self._ask(0)

    def close(self) -> None:
        """End the process."""
        self._process.terminate()
        self._process.join()

    def _ask(self, count: int) -> Any:
        self._connection.send(count)
        return self._answer()

    def _answer(self) -> Any:
        try:
            return self._connection.recv()
        except EOFError:
            raise UserError(f"training with rows on {self._home} ended early") from None


def _serve(connection: Connection, folder: Path, home: str) -> None:
    """Send the seconds to open the rows; then, forever, do as many updates as are asked for.

    Asked for 0, send the resident bytes instead.
    """
    jax.devices()  # starting the device does not count as opening
    begin = time.perf_counter()
    data = dataset.load(folder)
    split = data.split("train")
    rows = homes.open_rows(split, Home(home, "as asked"))
    jax.block_until_ready(rows.episode_ends)
    connection.send(time.perf_counter() - begin)
    env = envs.make(data.spec.environment)
    config = agents.get(_METHOD).preset(_PRESET)
    agent = agent_for(env, _METHOD, config, Statistics.of(rows.observations))
    init_key, key = jax.random.split(jax.random.key(0))
    states, done = [agents.create(agent, init_key)], 0
    with batches.of(rows, agent, key) as source:
        updates = make_updates(agent, key, source)
        while True:
            count = connection.recv()
            if count:
                states, _ = jax.block_until_ready(updates(states, done, done + count))
                done += count
            connection.send(None if count else _resident())


def _resident() -> int:
    """Resident bytes of this process, excluding pages of files."""
    lines = files.read_text(Path("/proc/self/status")).splitlines()
    values = dict(line.split(":", 1) for line in lines if ":" in line)
    return sum(int(values[name].split()[0]) * 1024 for name in ("RssAnon", "RssShmem"))


@contextmanager
def throw_away(environment: str, transitions: int, folder: Path | None) -> Iterator[Path]:
    """A temporary data set of that size: a few simulated episodes, repeated.

    It is made in `folder`, by default the system's folder of temporary files.
    """
    with tempfile.TemporaryDirectory(prefix="pigbench-rows-", dir=folder) as made:
        _write(environment, transitions, Path(made) / "data")
        yield Path(made) / "data"


def _write(environment: str, transitions: int, folder: Path) -> None:
    env = envs.make(environment)
    episodes = -(-transitions // (EPISODE_ROWS - 1))
    spec = Spec(
        environment=environment,
        policy="play",
        physics=env.scene.profile,
        engine=env.backend,
        seed=0,
        episodes={"train": episodes},
        episodes_per_shard=_SIMULATED,
        rows_per_episode=EPISODE_ROWS,
        fields=collect.COMPACT,
        layout=dataset.sizes(env.layout),
        action_size=env.action_size,
        versions=package_versions(),
    )
    simulate = collect.simulator(env, POLICIES["play"](env.scene), spec)
    with Progress("simulating", total=EPISODE_ROWS, unit="control steps") as progress:
        simulated = simulate(Shard("", "train", 0, _SIMULATED), progress.advance).arrays
    arrays = {
        field: np.concatenate([array] * (_EPISODES_PER_SHARD // _SIMULATED))
        for field, array in simulated.items()
    }
    spec = dataclasses.replace(spec, episodes_per_shard=_EPISODES_PER_SHARD)
    writer = Writer(folder, spec)
    missing = writer.missing()
    collect.require_room(env, spec.fields, episodes * EPISODE_ROWS, folder)
    with Progress("writing", total=len(missing), unit="shards") as progress:
        for part in missing:
            rows = part.episodes * EPISODE_ROWS
            writer.write(part, {field: array[:rows] for field, array in arrays.items()})
            progress.advance(1)
