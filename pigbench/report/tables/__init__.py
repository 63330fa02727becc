"""Tables of success rates: by environment, by task, aggregated, and between methods."""

from collections.abc import Callable, Mapping, Sequence

from pigbench.report import comparison, stats
from pigbench.report.formats import Table, render, render_all
from pigbench.report.stats import Result
from pigbench.report.tables.distances import noise_table, threshold_table
from pigbench.report.tables.milestones import milestone_table
from pigbench.report.tables.pooled import aggregate_table, improvement_table
from pigbench.report.tables.success import method_table, task_table

__all__ = [
    "TABLES",
    "Table",
    "aggregate_table",
    "improvement_table",
    "method_table",
    "milestone_table",
    "noise_table",
    "render",
    "render_all",
    "task_table",
    "telling",
    "threshold_table",
]

TABLES: Mapping[str, Callable[..., Table]] = {
    "methods": method_table,
    "tasks": task_table,
    "aggregate": aggregate_table,
    "improvement": improvement_table,
    "milestones": milestone_table,
    "thresholds": threshold_table,
    "noise": noise_table,
}


def telling(results: Sequence[Result]) -> list[str]:
    """The names of the `TABLES` that results can fill: some need several methods, or noise."""
    cells = stats.cells(results)
    pooled = bool(comparison.common_environments(cells))
    fits = {
        "aggregate": pooled,
        "improvement": pooled and len({cell.method for cell in cells}) > 1,
        "noise": any(
            set.intersection(*(set(result.run.noise_paths()) for result in group))
            for group in cells.values()
        ),
    }
    return [name for name in TABLES if fits.get(name, True)]
