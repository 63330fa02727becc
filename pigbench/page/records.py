"""The records of how a page's runs were made: configurations, provenance and commands."""

import dataclasses
import json
import shlex
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pigbench.page.entries import is_suite
from pigbench.report.order import ordered
from pigbench.report.stats import Cell
from pigbench.runs.run import Run, read_run
from pigbench.suite import jobs, spec
from pigbench.suite.jobs import Job
from pigbench.suite.logs import log_path
from pigbench.suite.spec import Environment, Suite
from pigbench.support import files, typed
from pigbench.support.compare import flatten, split
from pigbench.support.grouping import grouped

_NAMED = 3  # runs named, if more have the same provenance
_COMMAND = "command"


class Fields(NamedTuple):
    """Values by field, one per column; None if a column lacks the field. Headers have lines.

    Fields of `shared` have a single value, common to all columns. Fields of `partial` are missing
    in some columns and equal in the others.
    """

    columns: Sequence[Sequence[str]]
    shared: Mapping[str, Sequence[Any]]
    partial: Mapping[str, Sequence[Any]]
    differing: Mapping[str, Sequence[Any]]


class Commands(NamedTuple):
    """Commands, under a title that says what they made."""

    title: str
    lines: Sequence[str]


def configurations(runs: Sequence[Run], order: Sequence[str]) -> dict[str, Mapping[str, Any]]:
    """The configuration of each cell by its name, in order of environments and then of methods."""
    cells = grouped(runs, lambda run: Cell(run.config.label, run.config.environment))
    return {
        f"{environment} {method}": _configuration(cells[Cell(method, environment)])
        for environment in ordered({cell.environment for cell in cells}, order)
        for method in ordered({cell.method for cell in cells}, order)
        if Cell(method, environment) in cells
    }


def _configuration(runs: Sequence[Run]) -> dict[str, Any]:
    config = dataclasses.asdict(runs[0].config)
    del config["seed"]
    return config | {"seeds": sorted(run.config.seed for run in runs)}


def compared(configs: Mapping[str, Mapping[str, Any]]) -> Fields:
    """The fields of configurations by cell."""
    return _fields([name.split(" ", 1) for name in configs], list(configs.values()))


def _fields(columns: Sequence[Sequence[str]], configs: Sequence[Mapping[str, Any]]) -> Fields:
    shared, others = split(configs)
    partial = {
        name for name, values in others.items() if len(set(map(json.dumps, _had(values)))) < 2
    }
    return Fields(
        columns,
        {name: [value] for name, value in shared.items()},
        {name: values for name, values in others.items() if name in partial},
        {name: values for name, values in others.items() if name not in partial},
    )


def _had(values: Sequence[Any]) -> list[Any]:
    return [value for value in values if value is not None]


def provenance(runs: Sequence[Run]) -> Fields:
    """The fields of provenance except commands; runs that agree in all of them share a column."""
    groups = grouped(runs, lambda run: json.dumps(_origin(run)))
    columns = [_names(group) for group in groups.values()]
    return _fields(columns, [json.loads(origin) for origin in groups])


def commands(folders: Sequence[Path]) -> list[Commands]:
    """The command that makes this page, and those that made what it shows, as far as is known."""
    made = [Commands("This page", [typed.command()])]
    alone = [read_run(folder) for folder in folders if not is_suite(folder)]
    typed_for = [(run, _typed(run)) for run in alone]
    lines = [line for _, own in typed_for for line in own]
    if lines:
        made.append(Commands("Its runs", list(dict.fromkeys(lines))))
    unknown = [str(run.path) for run, own in typed_for if not own]
    if unknown:
        made.append(Commands("Runs whose commands are not recorded", unknown))
    for folder in filter(is_suite, folders):
        suite = spec.read_kept(folder / spec.KEPT)
        every = [
            *(job for one in suite.environments for job in _made_data(suite, one, folder)),
            *(jobs.training(suite, cell, folder) for cell in suite.cells()),
        ]
        made.append(Commands(f"The suite {folder}", [_line(job) for job in every]))
    return made


def _made_data(suite: Suite, environment: Environment, out: Path) -> Iterator[Job]:
    """The jobs that made an environment's data set: none if it was there before the suite."""
    for job in jobs.preparation(suite, environment, out):
        if environment.data is None or log_path(out, job.name).exists():
            yield job


def _line(job: Job) -> str:
    return shlex.join(["pigbench", *job.arguments])


def _names(runs: Sequence[Run]) -> list[str]:
    names = [f"{run.config.environment} {run.config.label} {run.config.seed}" for run in runs]
    more = len(names) - _NAMED
    return [*names[:_NAMED], f"and {more} more"] if more > 0 else names


def _kept(run: Run) -> Iterator[tuple[str, Any]]:
    """The fields of the run's provenance, with dotted names."""
    return flatten(files.read_json(run.provenance_path))


def _origin(run: Run) -> dict[str, Any]:
    return {name: value for name, value in _kept(run) if not _is_command(name)}


def _typed(run: Run) -> list[str]:
    """The commands that made and extended the run; empty if none were recorded."""
    return [value for name, value in _kept(run) if _is_command(name)]


def _is_command(field: str) -> bool:
    return field.rpartition(".")[-1] == _COMMAND
