"""Tables of success rates: by environment, by task, aggregated, and between methods."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from pigbench.report import comparison, stats
from pigbench.report.formats import Table, render, render_all
from pigbench.report.scoring import Cells
from pigbench.report.stats import Result
from pigbench.report.tables.distances import has_common_noise, noise_table, threshold_table
from pigbench.report.tables.milestones import milestone_table
from pigbench.report.tables.pooled import aggregate_table, improvement_table
from pigbench.report.tables.success import method_table, task_table

__all__ = [
    "TABLES",
    "Table",
    "TableKind",
    "aggregate_table",
    "fillable",
    "improvement_table",
    "method_table",
    "milestone_table",
    "noise_table",
    "render",
    "render_all",
    "task_table",
    "threshold_table",
]


class TableKind(NamedTuple):
    """A kind of table, and the function that makes it of results."""

    about: str
    make: Callable[..., Table]
    fits: Callable[[Cells], bool] = lambda cells: True  # whether cells can fill it


TABLES: Mapping[str, TableKind] = {
    "methods": TableKind("by environment", method_table),
    "tasks": TableKind("by method", task_table),
    "aggregate": TableKind(
        "interquartile mean over environments",
        aggregate_table,
        comparison.has_common_environment,
    ),
    "improvement": TableKind(
        "probability that one method is better than another",
        improvement_table,
        comparison.has_comparable_methods,
    ),
    "milestones": TableKind("how far episodes got", milestone_table),
    "thresholds": TableKind(
        "how near to their targets cubes end, beside the paper's robot", threshold_table
    ),
    "noise": TableKind("the same, by noise of the cubes' estimates", noise_table, has_common_noise),
}


def fillable(results: Sequence[Result]) -> list[str]:
    """The names of the `TABLES` that results can fill."""
    cells = stats.cells(results)
    return [name for name, kind in TABLES.items() if kind.fits(cells)]
