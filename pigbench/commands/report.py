"""`pigbench table`, `plot` and `report`: the results of runs, from their saved files alone."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import tyro

from pigbench.errors import UserError, lookup
from pigbench.page import make
from pigbench.report import order, plots, stats, tables
from pigbench.report.plots import PlotKind
from pigbench.report.scoring import Scoring
from pigbench.report.stats import Result
from pigbench.report.tables import TableKind
from pigbench.runs.run import read_run

Runs = tyro.conf.Positional[tuple[Path, ...]]
FlatScoring = Annotated[Scoring, tyro.conf.arg(name="")]  # --checkpoint, not --scoring.checkpoint


def _kinds(table: Mapping[str, TableKind | PlotKind]) -> str:
    """The help of an option that names kinds."""
    return ", ".join(f"{name} ({kind.about})" for name, kind in table.items()) + "."


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
    show: Annotated[tuple[str, ...], tyro.conf.arg(help=_kinds(tables.TABLES))] = (
        "methods",
        "tasks",
    )
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
    kind: Annotated[str, tyro.conf.arg(help=_kinds(plots.KINDS))] = "curves"
    scoring: FlatScoring = dataclasses.field(default_factory=Scoring)
    """How a run is scored; curves show every checkpoint."""

    def run(self) -> None:
        """Draw the picture."""
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
