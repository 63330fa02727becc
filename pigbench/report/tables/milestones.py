"""How far episodes got."""

from collections.abc import Sequence

from pigbench.evaluation.measures import MEASURES
from pigbench.report.formats import Table
from pigbench.report.scoring import DEFAULT, Scoring, milestones
from pigbench.report.stats import Result
from pigbench.report.tables import captions
from pigbench.report.tables.labels import rows_of


def milestone_table(
    results: Sequence[Result], *, order: Sequence[str] = (), scoring: Scoring = DEFAULT
) -> Table:
    """Methods of every environment by measures of how far episodes got."""
    cells = scoring.cells(results)
    rows = rows_of(cells, order)
    conditions = captions.conditions(cells, scoring)
    return Table(
        caption=(
            f"How far episodes got ({conditions}), mean ± standard deviation over "
            "seeds: percent of episodes unless the column names another unit. Nearest is the least "
            "distance of the pinch point from a cube; within is of all cubes from their targets, "
            f"final of the farthest; {captions.success_distances(cells)}. A dash: not recorded"
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
