"""`pigbench table`, `plot` and `report`: the results of runs, from their saved files alone."""

import dataclasses
from pathlib import Path
from typing import Annotated

import tyro

from pigbench.errors import UserError, lookup
from pigbench.page import make
from pigbench.report import order, stats, tables
from pigbench.report.scoring import Scoring
from pigbench.report.stats import Result
from pigbench.runs.run import read_run

Runs = tyro.conf.Positional[tuple[Path, ...]]
FlatScoring = Annotated[Scoring, tyro.conf.arg(name="")]  # --checkpoint, not --scoring.checkpoint


def _results(runs: tuple[Path, ...]) -> list[Result]:
    if not runs:
        raise UserError("no runs are given: name the folders of one or more")
    return stats.read_results(read_run(run) for run in runs)


@dataclasses.dataclass(frozen=True)
class PrintTable:
    """Print success rates in percent, as tables with captions that explain them.

    Each run gives one number; means, standard deviations and intervals are over seeds.
    """

    runs: Runs
    """Folders of runs."""
    show: tuple[str, ...] = ("methods", "tasks")
    """Tables: methods (by environment), tasks (by method), aggregate (interquartile mean over
    environments), improvement (probability that one method is better than another), milestones
    (how far episodes got), thresholds (how near to their targets cubes end, beside the paper's
    robot), noise (the same, by noise of the cubes' estimates)."""
    format: str = "markdown"
    """markdown, latex or csv."""
    scoring: FlatScoring = dataclasses.field(default_factory=Scoring)
    """How a run is scored."""

    def run(self) -> None:
        """Print the tables."""
        kinds = [lookup("table", tables.TABLES, name) for name in self.show]
        results = _results(self.runs)
        made = [
            kind.make(results, order=order.registered(), scoring=self.scoring) for kind in kinds
        ]
        print(tables.render_all(made, self.format))


@dataclasses.dataclass(frozen=True)
class DrawPlot:
    """Draw success rates over training, by task or over environments, or how far episodes got."""

    runs: Runs
    """Folders of runs."""
    out: Path
    """File of the picture; its extension (png, pdf, svg) chooses the format."""
    kind: str = "curves"
    """curves (over training steps), bars (by task), box (over environments), columns (curves by
    the input of a hierarchy's low level), profile (shares of runs above each success rate) or
    milestones (how far episodes got, from touching a cube to success)."""
    scoring: FlatScoring = dataclasses.field(default_factory=Scoring)
    """How a run is scored; curves show every checkpoint."""

    def run(self) -> None:
        """Draw the picture."""
        from pigbench.report import plots  # imports Matplotlib, which tables do not need

        plots.plot(
            _results(self.runs),
            self.out,
            kind=self.kind,
            order=order.registered(),
            scoring=self.scoring,
        )
        print(f"{self.out} is drawn")


@dataclasses.dataclass(frozen=True)
class MakePage:
    """Make a page of runs or of a suite, finished or not: tables, interactive figures, films,
    configurations, provenance and commands. It opens without a network.
    """

    runs: Runs
    """Folders of runs, or of suites."""
    out: Path = Path("report")
    """Folder for the page, index.html, and for films, if runs have any."""
    scoring: FlatScoring = dataclasses.field(default_factory=Scoring)
    """How a run is scored; curves show every checkpoint."""

    def run(self) -> None:
        """Make the page."""
        print(f"{make.page(self.runs, self.out, self.scoring)} is written")
