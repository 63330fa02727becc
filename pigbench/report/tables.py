"""Tables of success rates: by environment, by task, aggregated, and between methods."""

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence

from pigbench.errors import UserError
from pigbench.evaluation.measures import MEASURES
from pigbench.report import comparison, paper, stats
from pigbench.report.bootstrap import LEVEL
from pigbench.report.conditions import remarks
from pigbench.report.formats import Label, Table, render, render_all
from pigbench.report.scoring import (
    Cells,
    Scoring,
    differences,
    milestones,
    success,
    task_success,
    thresholds,
    wording,
)
from pigbench.report.stats import Cell, Estimate, Result
from pigbench.support.grouping import grouped

__all__ = [
    "TABLES",
    "Table",
    "aggregate_table",
    "improvement_table",
    "method_table",
    "milestone_table",
    "noise_table",
    "ordered",
    "render",
    "render_all",
    "task_table",
    "telling",
    "threshold_table",
]

DEFAULT = Scoring()


def method_table(
    results: Sequence[Result], *, order: Sequence[str] = (), scoring: Scoring = DEFAULT
) -> Table:
    """Methods by environments; names in `order` first, then others alphabetically."""
    cells = scoring.cells(results)
    estimates: dict[Label, Estimate] = {
        cell: success(group, scoring) for cell, group in cells.items()
    }
    return Table(
        caption=_caption(cells, estimates, scoring, line="column"),
        corner=("method", "environment"),
        rows=ordered({cell.method for cell in cells}, order),
        columns=ordered({cell.environment for cell in cells}, order),
        estimates=estimates,
        bold=_best(estimates, line=lambda label: label[1]),
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
        (_row_label(environment, task[1]), method): value
        for (environment, task, method), value in by_task.items()
    }
    return Table(
        caption=_caption(cells, estimates, scoring, line="row"),
        corner=("task", "method"),
        rows=[
            _row_label(name, task[1])
            for name in ordered({environment for environment, _ in tasks}, order)
            for environment, task in sorted(tasks)
            if environment == name
        ],
        columns=ordered({cell.method for cell in cells}, order),
        estimates=estimates,
        bold=_best(estimates, line=lambda label: label[0]),
    )


def aggregate_table(
    results: Sequence[Result], *, order: Sequence[str] = (), scoring: Scoring = DEFAULT
) -> Table:
    """Interquartile mean and mean of each method over the environments that all methods have."""
    cells = comparison.common(scoring.cells(results))
    pooled = comparison.pool(cells, scoring)
    estimates = comparison.aggregates(pooled, scoring)
    return Table(
        caption=(
            f"Success rate in percent ({_how(cells, scoring)}), interquartile mean and mean "
            f"{_pooling(pooled, estimates, scoring)}. {_bold_means(estimates, line='column')}"
        ),
        corner=("method", "aggregate"),
        rows=ordered(pooled.strata, order),
        columns=list(comparison.AGGREGATES),
        estimates=estimates,
        bold=_best(estimates, line=lambda label: label[1]),
    )


def improvement_table(
    results: Sequence[Result], *, order: Sequence[str] = (), scoring: Scoring = DEFAULT
) -> Table:
    """The probability that a row's method is better than a column's.

    Raises UserError if there is only one method.
    """
    cells = comparison.common(scoring.cells(results))
    pooled = comparison.pool(cells, scoring)
    estimates = comparison.improvements(pooled, scoring)
    return Table(
        caption=(
            "Probability in percent that a run of the row's method succeeds more often than one of "
            f"the column's ({_how(cells, scoring)}), {_pooling(pooled, estimates, scoring)}. "
            "Bold: the interval lies above 50"
        ),
        corner=("method", "other method"),
        rows=ordered(pooled.strata, order),
        columns=ordered(pooled.strata, order),
        estimates=estimates,
        bold={
            label
            for label, estimate in estimates.items()
            if estimate.interval is not None and estimate.interval.low > 50
        },
    )


def milestone_table(
    results: Sequence[Result], *, order: Sequence[str] = (), scoring: Scoring = DEFAULT
) -> Table:
    """Methods of every environment by measures of how far episodes got; ordered as above."""
    cells = scoring.cells(results)
    rows = _rows(cells, order)
    return Table(
        caption=(
            f"How far episodes got ({_how(cells, scoring)}), mean ± standard deviation over "
            "seeds: percent of episodes unless the column names another unit. Nearest is the least "
            "distance of the pinch point from a cube; within is of all cubes from their targets, "
            "final of the farthest; success (within 4 cm in OGBench's environments, 3 cm in "
            "cube-centre) ends an episode. A dash: not recorded"
        ),
        corner=("method", "measure"),
        rows=list(rows),
        columns=[measure.label for measure in MEASURES.values()],
        estimates={
            (label, column): estimate
            for label, cell in rows.items()
            for column, estimate in milestones(cells[cell], scoring).items()
        },
    )


def threshold_table(
    results: Sequence[Result], *, order: Sequence[str] = (), scoring: Scoring = DEFAULT
) -> Table:
    """Methods of every environment by how near cubes are to their targets at the end.

    The paper's results on its robot are given beside them.
    """
    cells = scoring.cells(results)
    rows = _rows(cells, order)
    ours = {
        (label, f"{_centimetres(distance)} cm"): estimate
        for label, cell in rows.items()
        for distance, estimate in thresholds(cells[cell], scoring).items()
    }
    theirs = {
        (label, f"paper, {_centimetres(distance)} cm"): Estimate(float(percent))
        for label, cell in rows.items()
        for distance, percent in paper.ROBOT.get((cell.method, cell.environment), {}).items()
    }
    estimates = ours | theirs
    return Table(
        caption=(
            f"Percentage of episodes ({_how(cells, scoring)}) that end with all cubes within so "
            "many centimetres of their targets, mean ± standard deviation over seeds. An episode "
            "ends with success: within 4 cm in OGBench's environments, 3 cm in cube-centre"
            + ("; the paper's are from its robot, 20 episodes of one seed" if theirs else "")
        ),
        corner=("method", "distance"),
        rows=list(rows),
        columns=list(dict.fromkeys(column for _, column in estimates)),
        estimates=estimates,
    )


def noise_table(
    results: Sequence[Result], *, order: Sequence[str] = (), scoring: Scoring = DEFAULT
) -> Table:
    """Methods and distances by the noise of the cubes' estimates.

    Raises UserError if no method has a noise level at which all its runs were evaluated.
    """
    cells = scoring.cells(results)
    rows = _rows(cells, order)
    by_noise = _by_noise(cells, scoring)
    estimates = {
        (f"{label}, {_centimetres(distance)} cm", level): estimate
        for label, cell in rows.items()
        for level, noisy in by_noise.items()
        if cell in noisy
        for distance, estimate in thresholds(noisy[cell], scoring).items()
    }
    if not estimates:
        raise UserError("no run was evaluated in other noise; use `pigbench evaluate --noise`")
    levels = sorted({level for _, level in estimates})
    evaluated = {
        Cell(f"{cell.method} at {level:g} mm", cell.environment): group
        for level, noisy in by_noise.items()
        for cell, group in noisy.items()
    }
    return Table(
        caption=(
            f"Percentage of episodes ({_how(evaluated, scoring)}) that end with all cubes within "
            "so many centimetres of their targets, by the standard deviation of each coordinate of "
            "a cube's estimate; mean ± standard deviation over seeds. Policies were trained with "
            "the environment's own noise"
        ),
        corner=("method, distance", "noise"),
        rows=list(dict.fromkeys(row for row, _ in estimates)),
        columns=[f"{level:g} mm" for level in levels],
        estimates={(row, f"{level:g} mm"): value for (row, level), value in estimates.items()},
    )


def _rows(cells: Iterable[Cell], order: Sequence[str]) -> dict[str, Cell]:
    """A row for each cell, by label: environments in order, then methods in order."""
    cells = set(cells)
    every = (
        Cell(method, environment)
        for environment in ordered({cell.environment for cell in cells}, order)
        for method in ordered({cell.method for cell in cells}, order)
    )
    return {_row_label(cell.environment, cell.method): cell for cell in every if cell in cells}


def _by_noise(cells: Cells, scoring: Scoring) -> dict[float, Cells]:
    """The cells at each noise level at which all their runs were evaluated.

    Raises UserError if results at the same level are not comparable.
    """
    found = {cell: list(map(stats.noisy, group)) for cell, group in cells.items()}
    levels = {cell: set.intersection(*map(set, own)) for cell, own in found.items()}
    by_noise = {}
    for level in sorted(set.union(*levels.values())):
        noisy = [one[level] for cell, own in found.items() if level in levels[cell] for one in own]
        try:
            by_noise[level] = scoring.cells(noisy)
        except UserError as error:
            raise UserError(f"in noise of {level:g} mm: {error}") from None
    return by_noise


def _centimetres(distance: float) -> str:
    return f"{100 * distance:g}"


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


def ordered(names: Iterable[str], order: Sequence[str]) -> list[str]:
    """`names` without repetition: first those in `order`, in that order, then others by alphabet.

    A method's variants, named as in "method (variant)", are placed where the method is.
    """
    rank = {name: number for number, name in enumerate(order)}
    return sorted(set(names), key=lambda name: (rank.get(stats.base(name), len(rank)), name))


def _best(estimates: Mapping[Label, Estimate], line: Callable[[Label], str]) -> set[Label]:
    """The highest of each line, and what is in its interval; none of a line with one number."""
    lines = grouped(estimates, line).values()
    return {label for labels in lines if len(labels) > 1 for label in _highest(estimates, labels)}


def _highest(estimates: Mapping[Label, Estimate], labels: Sequence[Label]) -> list[Label]:
    best = max((estimates[label] for label in labels), key=lambda estimate: estimate.value)
    least = best.interval.low if best.interval else best.value
    return [label for label in labels if estimates[label].value >= least]


def _caption(
    cells: Cells,
    estimates: Mapping[Label, Estimate],
    scoring: Scoring,
    *,
    line: str,
) -> str:
    return (
        f"Success rate in percent ({_how(cells, scoring)}), mean ± standard deviation over "
        f"seeds. {_bold_means(estimates, line=line)}"
    )


def _how(cells: Cells, scoring: Scoring) -> str:
    results = itertools.chain.from_iterable(cells.values())
    told = remarks(results, always=("physics",))
    return "; ".join([wording(cells, scoring), *told, *differences(cells, scoring)])


def _bold_means(estimates: Mapping[Label, Estimate], *, line: str) -> str:
    if _have_intervals(estimates):
        return f"Bold: the highest of a {line} and what lies in its {LEVEL} % bootstrap interval"
    return f"Bold: the highest of a {line}; a single seed gives no interval"


def _pooling(pooled: comparison.Pool, estimates: Mapping[Label, Estimate], scoring: Scoring) -> str:
    over = {"environments": "over", "tasks": "over the tasks of"}[scoring.over]
    intervals = (
        f", with {LEVEL} % stratified bootstrap intervals over seeds"
        if _have_intervals(estimates)
        else ""
    )
    return f"{over} {', '.join(pooled.environments)}{intervals}"


def _have_intervals(estimates: Mapping[Label, Estimate]) -> bool:
    return any(estimate.interval for estimate in estimates.values())


def _row_label(environment: str, name: str) -> str:
    return f"{environment} {name}"
