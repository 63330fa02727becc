"""The paper's ablation in three columns: what the low level of a hierarchy should see.

One column per low-level representation, with one curve per method, and a last column for the
average over the methods that have every representation; one row per environment.
"""

import itertools
from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from pigbench.errors import UserError
from pigbench.report import canvas, stats
from pigbench.report.curves import add_curve, prepare
from pigbench.report.order import ordered
from pigbench.report.representations import REPRESENTATIONS, representation, shown_names
from pigbench.report.scoring import Cells, Scoring, curve_remarks
from pigbench.report.stats import Cell, Estimate, Result
from pigbench.report.styles import styles
from pigbench.support.grouping import grouped

_PANEL = 2.9, 2.2


def draw(results: Sequence[Result], order: Sequence[str], scoring: Scoring) -> Figure:
    """Curves like those of `curves`. Raises UserError if no method is hierarchical."""
    cells = scoring.cells(result for result in results if result.representation)
    if not cells:
        raise UserError("columns compare low-level representations: give runs of hierarchies")
    names = ordered(
        {str(group[0].representation) for group in cells.values()}, list(REPRESENTATIONS)
    )
    environments = ordered({cell.environment for cell in cells}, order)
    rows = {environment: _by_representation(cells, environment) for environment in environments}
    methods = ordered(
        {method for row in rows.values() for groups in row.values() for method in groups}, order
    )
    titles = {name: representation(name).title for name in names}
    figure, grid = canvas.grid(
        len(environments),
        len(names) + 1,
        panel=_PANEL,
        legend=[*methods, *titles.values()],
    )
    for panel, title in zip(grid[0], titles.values(), strict=False):
        panel.set_title(title)
    looks, handles = styles(methods), {}
    for panels, (environment, row) in zip(grid, rows.items(), strict=True):
        panels[0].set_ylabel(f"{environment}\nsuccess (%)")
        for panel in panels:
            prepare(panel)
        for panel, name in zip(panels, names, strict=False):
            for method, group in row.get(name, {}).items():
                handles[method] = add_curve(panel, stats.success_curve(group), looks[method])
        shared = ordered(set.intersection(*map(set, row.values())), order)
        panels[-1].set_title(canvas.wrapped(_average_title(shared, methods), _PANEL[0]))
        for name, groups in row.items() if shared else ():
            curve = _average([groups[method] for method in shared])
            handles[titles[name]] = add_curve(panels[-1], curve, representation(name).style)
    canvas.add_remarks(figure, curve_remarks(itertools.chain.from_iterable(cells.values())))
    canvas.add_legend(
        figure, {name: handles[name] for name in [*methods, *titles.values()] if name in handles}
    )
    return figure


def _by_representation(cells: Cells, environment: str) -> dict[str, dict[str, Sequence[Result]]]:
    """The results of methods in an environment, by representation and then by name."""
    low_levels = {
        cell.method: str(group[0].representation)
        for cell, group in cells.items()
        if cell.environment == environment
    }
    names = shown_names(low_levels)
    return {
        name: {names[method]: cells[Cell(method, environment)] for method in methods}
        for name, methods in grouped(low_levels, low_levels.__getitem__).items()
    }


def _average_title(shared: Sequence[str], methods: Sequence[str]) -> str:
    if not shared:
        return "no average: no method has all representations"
    return f"average over {'methods' if len(shared) == len(methods) else ', '.join(shared)}"


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
