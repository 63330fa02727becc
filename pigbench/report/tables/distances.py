"""How near cubes are to their targets at the end, also by the noise of their estimates."""

from collections.abc import Sequence

from pigbench.errors import UserError
from pigbench.report import paper, stats
from pigbench.report.formats import Table
from pigbench.report.scoring import DEFAULT, Cells, Scoring, thresholds
from pigbench.report.stats import Cell, Estimate, Result
from pigbench.report.tables import captions
from pigbench.report.tables.labels import centimetres, rows_of


def threshold_table(
    results: Sequence[Result], *, order: Sequence[str] = (), scoring: Scoring = DEFAULT
) -> Table:
    """Methods of every environment by how near cubes are to their targets at the end.

    The paper's results on its robot are given beside them.
    """
    cells = scoring.cells(results)
    rows = rows_of(cells, order)
    ours = {
        (label, f"{centimetres(distance)} cm"): estimate
        for label, cell in rows.items()
        for distance, estimate in thresholds(cells[cell], scoring).items()
    }
    theirs = {
        (label, f"paper, {centimetres(distance)} cm"): Estimate(float(percent))
        for label, cell in rows.items()
        for distance, percent in paper.ROBOT.get((cell.method, cell.environment), {}).items()
    }
    estimates = ours | theirs
    conditions = captions.conditions(cells, scoring)
    return Table(
        caption=(
            f"Percentage of episodes ({conditions}) that end with all cubes within so "
            "many centimetres of their targets, mean ± standard deviation over seeds; "
            + captions.success_distances(cells)
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
    rows = rows_of(cells, order)
    by_noise = _by_noise(cells, scoring)
    estimates = {
        (f"{label}, {centimetres(distance)} cm", level): estimate
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
    conditions = captions.conditions(evaluated, scoring)
    return Table(
        caption=(
            f"Percentage of episodes ({conditions}) that end with all cubes within "
            "so many centimetres of their targets, by the standard deviation of each coordinate of "
            "a cube's estimate; mean ± standard deviation over seeds. Policies were trained with "
            "the environment's own noise"
        ),
        corner=("method, distance", "noise"),
        rows=list(dict.fromkeys(row for row, _ in estimates)),
        columns=[f"{level:g} mm" for level in levels],
        estimates={(row, f"{level:g} mm"): value for (row, level), value in estimates.items()},
    )


def has_common_noise(cells: Cells) -> bool:
    """Whether some method has a noise level at which all its runs were evaluated."""
    return any(
        set.intersection(*(set(result.run.noise_paths()) for result in group))
        for group in cells.values()
    )


def _by_noise(cells: Cells, scoring: Scoring) -> dict[float, Cells]:
    """The cells at each noise level at which all their runs were evaluated.

    Raises UserError if results at the same level are not comparable.
    """
    found = {cell: list(map(stats.results_in_noise, group)) for cell, group in cells.items()}
    levels = {cell: set.intersection(*map(set, own)) for cell, own in found.items()}
    by_noise = {}
    for level in sorted(set.union(*levels.values())):
        noisy = [one[level] for cell, own in found.items() if level in levels[cell] for one in own]
        try:
            by_noise[level] = scoring.cells(noisy)
        except UserError as error:
            raise UserError(f"in noise of {level:g} mm: {error}") from None
    return by_noise
