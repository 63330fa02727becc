"""Processor time that commands take to start, each in a process of its own."""

import os
import statistics
import subprocess
from collections.abc import Mapping, Sequence

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


def measure(turns: int) -> Mapping[str, Sequence[float]]:
    """The processor seconds that some commands take, in each turn."""
    taken: dict[str, list[float]] = {command: [] for command in _STARTED}
    with Progress("bench startup", total=turns * len(taken), unit="starts") as progress:
        for _ in range(turns):
            for command, times in taken.items():
                times.append(seconds(command.split()))
                progress.advance(1, command)
    return taken


def table(taken: Mapping[str, Sequence[float]]) -> list[tuple[str, ...]]:
    """The median of each command, with a header."""
    lines = [(name, f"{statistics.median(times):.2f}") for name, times in taken.items()]
    return [("pigbench", "processor seconds"), *lines]


def seconds(arguments: Sequence[str]) -> float:
    """User plus system time of one `pigbench` command. Raises UserError if it fails."""
    before = os.times()
    ended = subprocess.run(
        command_line(arguments),
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
