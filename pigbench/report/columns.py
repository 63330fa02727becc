"""The paper's ablation in three columns: what the low level of a hierarchy should see.

One column per low-level representation, with one curve per method, and a last column for the
average over methods with each representation; one row per environment.
"""

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from pigbench.errors import UserError
from pigbench.report import canvas, stats
from pigbench.report.curves import add_curve, prepare
from pigbench.report.representations import REPRESENTATIONS, representation
from pigbench.report.scoring import Scoring
from pigbench.report.stats import Estimate, Result, base
from pigbench.report.styles import style
from pigbench.report.tables import ordered

_PANEL = 2.9, 2.2


def draw(results: Sequence[Result], order: Sequence[str], scoring: Scoring) -> Figure:
    """Curves like those of `curves`. Raises UserError if no method is hierarchical."""
    cells = stats.cells(result for result in results if result.representation)
    if not cells:
        raise UserError("columns compare low-level representations: give runs of hierarchies")
    names = ordered(
        {str(group[0].representation) for group in cells.values()}, list(REPRESENTATIONS)
    )
    methods = ordered({base(cell.method) for cell in cells}, order)
    environments = ordered({cell.environment for cell in cells}, order)
    titles = {name: representation(name).title for name in names}
    figure, grid = canvas.grid(
        len(environments),
        len(names) + 1,
        panel=_PANEL,
        legend=[*methods, *titles.values()],
    )
    handles = {}
    for row, environment in zip(grid, environments, strict=True):
        row[0].set_ylabel(f"{environment}\nsuccess (%)")
        for panel in row:
            prepare(panel)
        for panel, name in zip(row, names, strict=False):
            groups = {
                base(cell.method): group
                for cell, group in cells.items()
                if (cell.environment, group[0].representation) == (environment, name)
            }
            for method, group in groups.items():
                handles[method] = add_curve(panel, stats.success_curve(group), style(method))
            if groups:
                curve = _average(list(groups.values()))
                handles[titles[name]] = add_curve(row[-1], curve, representation(name).style)
    for panel, title in zip(grid[0], [*titles.values(), "average over methods"], strict=True):
        panel.set_title(title)
    canvas.add_legend(figure, {name: handles[name] for name in [*methods, *titles.values()]})
    return figure


def _average(groups: Sequence[Sequence[Result]]) -> Mapping[int, Estimate]:
    """The curve over seeds of the mean over methods; each group has the results of one method.

    Raises UserError if the methods have no seed in common.
    """
    by_seed = [
        {result.run.config.seed: stats.run_curve(result) for result in group} for group in groups
    ]
    seeds = sorted(set.intersection(*map(set, by_seed)))
    if not seeds:
        raise UserError("the methods have no seed in common: their average needs one")
    means = [stats.estimate_curve([curves[seed] for curves in by_seed]) for seed in seeds]
    return stats.estimate_curve(
        [{step: estimate.value for step, estimate in curve.items()} for curve in means]
    )
