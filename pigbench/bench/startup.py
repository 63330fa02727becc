"""Processor time that commands take to start, each in a process of its own.

What little work takes is mostly compiling, of which JAX keeps the results for later commands: the
first commands start with an empty cache, and the same ones again find it filled.
"""

import os
import statistics
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from pigbench.errors import UserError
from pigbench.support.processes import command_line
from pigbench.support.progress import Progress

_STARTED = (
    "--help",
    "list envs",
    "list methods",
    "data info --help",
    "table --help",
    "plot --help",
    "suite status --help",
    "generate --help",
    "train --help",
    "evaluate --help",
)

_WORK = (
    "generate cube-single --episodes 2 --validation-episodes 1 --episode-length 50 --out data",
    "train gcivl --preset cpu --data data --out run --steps 20 --evaluation.episodes 2",
    "evaluate run --episodes 2",
)
_CACHES = ("empty cache", "filled cache")

Seconds = Mapping[str, Sequence[float]]
"""Processor seconds of commands, in each turn."""


def measure(turns: int) -> Seconds:
    """The processor seconds that some commands take which only look at something."""
    taken: dict[str, list[float]] = {command: [] for command in _STARTED}
    with Progress("bench startup", total=turns * len(taken), unit="starts") as progress:
        for _ in range(turns):
            for command, times in taken.items():
                times.append(seconds(command.split()))
                progress.advance(1, command)
    return taken


def measure_work(turns: int) -> Mapping[str, Seconds]:
    """The same for commands that do little work, by whether their programs are compiled already."""
    taken: dict[str, dict[str, list[float]]] = {
        cache: {command: [] for command in _WORK} for cache in _CACHES
    }
    total = turns * len(_CACHES) * len(_WORK)
    with Progress("bench startup", total=total, unit="starts") as progress:
        for _ in range(turns):
            with tempfile.TemporaryDirectory(prefix="pigbench-startup-") as place:
                environment = {"JAX_COMPILATION_CACHE_DIR": f"{place}/compiled"}
                for cache, times in taken.items():
                    folder = Path(place) / cache
                    folder.mkdir()
                    for command in _WORK:
                        spent = seconds(command.split(), folder=folder, environment=environment)
                        times[command].append(spent)
                        progress.advance(1, command)
    return taken


def table(taken: Mapping[str, Seconds]) -> list[tuple[str, ...]]:
    """The median of each command in columns of those names, with a header."""
    commands = next(iter(taken.values()))
    lines = [
        (name, *(f"{statistics.median(times[name]):.2f}" for times in taken.values()))
        for name in commands
    ]
    return [("pigbench", *taken), *lines]


def seconds(
    arguments: Sequence[str],
    *,
    folder: Path | None = None,
    environment: Mapping[str, str] = MappingProxyType({}),
) -> float:
    """User plus system time of one `pigbench` command. Raises UserError if it fails.

    It runs in `folder`, by default this process's, with further variables in its `environment`.
    """
    before = os.times()
    ended = subprocess.run(
        command_line(arguments),
        cwd=folder,
        env=os.environ | environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    after = os.times()
    if ended.returncode:
        raise UserError(f"pigbench {' '.join(arguments)} failed: {ended.stderr.strip()}")
    return (after.children_user - before.children_user) + (
        after.children_system - before.children_system
    )
