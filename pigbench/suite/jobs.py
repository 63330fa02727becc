"""The commands that a suite consists of: one for each data set, and one for each cell."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pigbench.envs.scripted import SCRIPTED
from pigbench.errors import lookup
from pigbench.suite.spec import Environment, Suite, SuiteCell


@dataclass(frozen=True)
class Job:
    """A `pigbench` command that writes a folder; its name is unique within the suite.

    `after` is the name of the job that must have ended before it starts, if there is one.
    """

    name: str
    folder: Path
    arguments: tuple[str, ...]
    after: str = ""


def preparation(suite: Suite, environment: Environment, out: Path) -> tuple[Job, ...]:
    """The jobs that make or complete an environment's data set, to be run one after another."""
    name, folder = data_job(environment), data_folder(environment, out)
    if not suite.data.filter:
        return (_generation(suite, environment, name, folder),)
    raw = folder.with_name(f"{folder.name}-raw")
    keep = ("data", "filter", str(raw), "--out", str(folder))
    collect = _generation(suite, environment, f"{name}-raw", raw)
    return collect, Job(name, folder, keep, after=collect.name)


def _generation(suite: Suite, environment: Environment, name: str, folder: Path) -> Job:
    data = suite.data
    options: dict[str, Any] = {
        "out": folder,
        "policy": data.policy,
        "physics": data.physics,
        "seed": data.seed,
        "episodes": -(-environment.transitions // data.episode_transitions),
        "compact": data.compact,
    }
    if not lookup("policy", SCRIPTED, data.policy).episode_rows:
        options["episode-length"] = data.episode_transitions + 1
    if data.validation_episodes is not None:
        options["validation-episodes"] = data.validation_episodes
    return Job(name, folder, ("generate", environment.name, *_flags(options)))


def training(suite: Suite, cell: SuiteCell, out: Path) -> Job:
    """The job that trains and evaluates a cell."""
    folder = out / cell.name
    options = {
        "data": data_folder(cell.environment, out),
        "out": folder,
        "preset": suite.preset,
        "rows": suite.rows,
        "keep": suite.keep,
        "logger": suite.logger,
        "films": suite.films,
        "variant": cell.variant,
        "seed": cell.seed,
        "steps": cell.environment.steps,
        "evaluate-every": suite.evaluation.every,
        "evaluation.episodes": suite.evaluation.episodes,
    } | {f"agent.{name}": value for name, value in suite.overrides(cell).items()}
    return Job(cell.name, folder, ("train", cell.method, *_flags(options)))


def noise(suite: Suite, cell: SuiteCell, out: Path, levels: Sequence[float]) -> Job:
    """The job that evaluates a trained cell at these noise levels of the estimates, in mm."""
    folder = out / cell.name
    options = {"episodes": suite.evaluation.episodes, "noise": levels}
    return Job(f"noise/{cell.name}", folder, ("evaluate", str(folder), *_flags(options)))


def data_job(environment: Environment) -> str:
    """The name of the job that makes an environment's data set."""
    return f"data/{environment.name}"


def data_folder(environment: Environment, out: Path) -> Path:
    """The folder of an environment's data set."""
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
