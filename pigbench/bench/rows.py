"""Training timed with rows in each of their homes, each in a process of its own."""

import contextlib
import multiprocessing
import time
from collections.abc import Mapping, Sequence
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NamedTuple

import jax

from pigbench import agents, envs, seeds
from pigbench.agents import Statistics
from pigbench.bench.timing import Contender, Timing
from pigbench.bench.turns import Turns, take_turns
from pigbench.data import dataset, homes
from pigbench.data.dataset import Split
from pigbench.data.homes import Home
from pigbench.errors import UserError
from pigbench.support import files
from pigbench.training import batches
from pigbench.training.updates import make_updates

_METHOD, _PRESET = "gcivl", "cpu"


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
    agent = agents.build(_METHOD, config, env.space, statistics=Statistics.of(rows.observations))
    init_key, key = jax.random.split(seeds.key(0))
    state, done = agents.create(agent, init_key), 0
    with batches.of(rows, agent, key) as source:
        updates = make_updates(agent, key, source)
        while True:
            count = connection.recv()
            if count:
                state, _ = jax.block_until_ready(updates(state, done, done + count))
                done += count
            connection.send(None if count else _resident())


def _resident() -> int:
    """Resident bytes of this process, excluding pages of files."""
    lines = files.read_text(Path("/proc/self/status")).splitlines()
    values = dict(line.split(":", 1) for line in lines if ":" in line)
    return sum(int(values[name].split()[0]) * 1024 for name in ("RssAnon", "RssShmem"))


class Measured(NamedTuple):
    """Measurements by the home of the rows; sizes are in bytes, without pages of files."""

    timings: Mapping[str, Timing]
    opened: Mapping[str, float]  # seconds
    resident: Mapping[str, int]


def possible(split: Split) -> tuple[Home, list[str]]:
    """The home that `auto` chooses for the rows, and the names of all homes that they fit."""
    home = homes.choose("auto", split)
    return home, ["device", "disk"] if home.name == "device" else ["disk"]


def measure(folder: Path, names: Sequence[str], turns: Turns) -> Measured:
    """Time training on the data set in `folder` with its rows in each of the named homes."""
    with contextlib.ExitStack() as stack:
        trainers = {
            name: stack.enter_context(contextlib.closing(Trainer(folder, name))) for name in names
        }
        contenders = [trainer.contender() for trainer in trainers.values()]
        return Measured(
            timings=take_turns("bench rows", contenders, turns),
            opened={name: trainer.seconds_to_open for name, trainer in trainers.items()},
            resident={name: trainer.resident() for name, trainer in trainers.items()},
        )


def table(measured: Measured) -> list[tuple[str, ...]]:
    """One line per home, compared with the first, and a header."""
    first = next(iter(measured.timings))
    lines = [
        (
            name,
            f"{measured.opened[name]:.2f}",
            f"{1 / timing.median:.1f}",
            f"{measured.timings[first].ratio(timing):.2f}",
            f"{measured.resident[name] / 1e9:.2f}",
        )
        for name, timing in measured.timings.items()
    ]
    header = ("rows on", "s to open", "updates per second", f"times {first}", "GB resident")
    return [header, *lines]
