"""Success rates by environment and by task."""

from collections.abc import Sequence

from pigbench.report.formats import Label, Table
from pigbench.report.order import ordered
from pigbench.report.scoring import DEFAULT, Scoring, success, task_success
from pigbench.report.stats import Estimate, Result
from pigbench.report.tables import bold, captions
from pigbench.report.tables.labels import row_label


def method_table(
    results: Sequence[Result], *, order: Sequence[str] = (), scoring: Scoring = DEFAULT
) -> Table:
    """Methods by environments; names in `order` first, then others alphabetically."""
    cells = scoring.cells(results)
    estimates: dict[Label, Estimate] = {
        cell: success(group, scoring) for cell, group in cells.items()
    }
    return Table(
        caption=captions.success_rates(cells, estimates, scoring, line="column"),
        corner=("method", "environment"),
        rows=ordered({cell.method for cell in cells}, order),
        columns=ordered({cell.environment for cell in cells}, order),
        estimates=estimates,
        bold=bold.best(estimates, line=lambda label: label[1]),
    )


def task_table(
    results: Sequence[Result], *, order: Sequence[str] = (), scoring: Scoring = DEFAULT
) -> Table:
    """Tasks of every environment by methods; names ordered as in `method_table`."""
    cells = scoring.cells(results)
    by_task = {
        (cell.environment, task, cell.method): value
        for cell, group in cells.items()
        for task, value in task_success(group, scoring).items()
    }
    tasks = {(environment, task) for environment, task, _ in by_task}
    estimates = {
        (row_label(environment, task[1]), method): value
        for (environment, task, method), value in by_task.items()
    }
    return Table(
        caption=captions.success_rates(cells, estimates, scoring, line="row"),
        corner=("task", "method"),
        rows=[
            row_label(name, task[1])
            for name in ordered({environment for environment, _ in tasks}, order)
            for environment, task in sorted(tasks)
            if environment == name
        ],
        columns=ordered({cell.method for cell in cells}, order),
        estimates=estimates,
        bold=bold.best(estimates, line=lambda label: label[0]),
    )
