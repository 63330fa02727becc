"""The commands that a suite consists of: one for each data set, and one for each cell."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pigbench.suite.spec import Cell, Environment, Suite

EPISODE_LENGTH = 1001  # rows: one transition fewer


@dataclass(frozen=True)
class Job:
    """A `pigbench` command that writes a folder, under a name that no other of the suite has."""

    name: str
    folder: Path
    arguments: tuple[str, ...]


def generation(suite: Suite, environment: Environment, out: Path) -> Job:
    """The job that makes an environment's data set, or what of it is missing."""
    data, folder = suite.data, data_folder(environment, out)
    options: dict[str, Any] = {
        "out": folder,
        "policy": data.policy,
        "physics": data.physics,
        "seed": data.seed,
        "episodes": math.ceil(environment.transitions / (EPISODE_LENGTH - 1)),
        "episode-length": EPISODE_LENGTH,
    }
    if data.validation_episodes is not None:
        options["validation-episodes"] = data.validation_episodes
    return Job(data_job(environment), folder, ("generate", environment.name, *_flags(options)))


def training(suite: Suite, cell: Cell, out: Path) -> Job:
    """The job that trains and evaluates a cell."""
    folder = out / cell.name
    options = {
        "data": data_folder(cell.environment, out),
        "out": folder,
        "preset": suite.preset,
        "rows": suite.rows,
        "keep": suite.keep,
        "variant": cell.variant,
        "seed": cell.seed,
        "steps": cell.environment.steps,
        "evaluate-every": suite.evaluation.every,
        "evaluation.episodes": suite.evaluation.episodes,
    } | {f"agent.{name}": value for name, value in suite.overrides(cell).items()}
    return Job(cell.name, folder, ("train", cell.method, *_flags(options)))


def data_job(environment: Environment) -> str:
    """The name of the job that makes an environment's data set."""
    return f"data/{environment.name}"


def data_folder(environment: Environment, out: Path) -> Path:
    """Where an environment's data set lies."""
    return environment.data or out / "data" / environment.name


def _flags(options: Mapping[str, Any]) -> list[str]:
    return [text for name, value in options.items() for text in _flag(name, value)]


def _flag(name: str, value: Any) -> list[str]:
    name = name.replace("_", "-")
    if isinstance(value, bool):
        group, dot, last = name.rpartition(".")
        return [f"--{name}" if value else f"--{group}{dot}no-{last}"]
    values = value if isinstance(value, list | tuple) else [value]
    return [f"--{name}", *map(str, values)]
