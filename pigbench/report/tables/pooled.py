"""Success over several environments at once, and comparisons between methods."""

from collections.abc import Sequence

from pigbench.report import comparison
from pigbench.report.formats import Table
from pigbench.report.order import ordered
from pigbench.report.scoring import DEFAULT, Scoring
from pigbench.report.stats import Result
from pigbench.report.tables import bold, captions


def aggregate_table(
    results: Sequence[Result], *, order: Sequence[str] = (), scoring: Scoring = DEFAULT
) -> Table:
    """Interquartile mean and mean of each method over the environments that all methods have."""
    cells = comparison.common(scoring.cells(results))
    pooled = comparison.pool(cells, scoring)
    estimates = comparison.aggregated(pooled, scoring)
    conditions = captions.conditions(cells, scoring)
    pooling = captions.pooling(pooled, estimates, scoring)
    return Table(
        caption=(
            f"Success rate in percent ({conditions}), interquartile mean and mean "
            f"{pooling}. {bold.meaning(estimates, line='column')}"
        ),
        corner=("method", "aggregate"),
        rows=ordered(pooled.strata, order),
        columns=list(comparison.AGGREGATES),
        estimates=estimates,
        bold=bold.best(estimates, line=lambda label: label[1]),
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
    conditions = captions.conditions(cells, scoring)
    pooling = captions.pooling(pooled, estimates, scoring)
    return Table(
        caption=(
            "Probability in percent that a run of the row's method succeeds more often than one of "
            f"the column's ({conditions}), {pooling}. Bold: the interval lies above 50"
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
