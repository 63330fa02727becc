"""`pigbench table` and `pigbench plot`: what runs achieved, from their saved files alone."""

import dataclasses
from pathlib import Path

import tyro

from pigbench import agents, envs
from pigbench.errors import UserError
from pigbench.report import plots, stats, tables
from pigbench.report.stats import Result
from pigbench.training.run import read_run

Runs = tyro.conf.Positional[tuple[Path, ...]]


def _results(runs: tuple[Path, ...]) -> list[Result]:
    if not runs:
        raise UserError("no runs are given: name the folder of one or more")
    return stats.read_results(read_run(run) for run in runs)


def _order() -> tuple[str, ...]:
    return (*agents.names(), *envs.names())


@dataclasses.dataclass(frozen=True)
class Table:
    """Print success rates in percent: methods by environments, and task by task.

    Mean and standard deviation are over seeds.
    """

    runs: Runs
    """Folders of runs."""
    format: str = "markdown"
    """markdown, latex or csv."""

    def run(self) -> None:
        """Print both tables."""
        results = _results(self.runs)
        for make in (tables.method_table, tables.task_table):
            print(tables.render(make(results, order=_order()), self.format))


@dataclasses.dataclass(frozen=True)
class Plot:
    """Draw success over training steps, one panel an environment, with a band over seeds."""

    runs: Runs
    """Folders of runs."""
    out: Path
    """File of the picture; its extension (png, pdf, svg) tells the format."""

    def run(self) -> None:
        """Draw the curves."""
        plots.plot_curves(_results(self.runs), self.out, order=_order())
        print(f"{self.out} is drawn")
