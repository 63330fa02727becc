"""Bar charts, one panel per environment: success on each task, or how far episodes got."""

import math
from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.container import BarContainer
from matplotlib.figure import Figure

from pigbench.report import canvas
from pigbench.report.order import ordered
from pigbench.report.scoring import Groups, Scoring, by_stage, by_task, score_remarks, wording
from pigbench.report.stats import Cell, Estimate, Result
from pigbench.report.styles import Style, styles

_HEIGHT = 2.1  # inches
_BAR = 0.11
_LEAST_GROUP = 1.3  # enough for a task's name
_GAP = 1.0  # bars


def draw(results: Sequence[Result], order: Sequence[str], scoring: Scoring) -> Figure:
    """One bar per method: the mean over seeds, with whiskers of one standard deviation each way."""
    return _draw(results, order, scoring, by_task, quantity="success (%)")


def draw_milestones(results: Sequence[Result], order: Sequence[str], scoring: Scoring) -> Figure:
    """Like `draw`, for the share of episodes that reached each stage, from touching to success.

    A dash takes the place of a bar that a run's file does not determine.
    """
    return _draw(results, order, scoring, by_stage, quantity="episodes (%)")


def _draw(
    results: Sequence[Result],
    order: Sequence[str],
    scoring: Scoring,
    groups_of: Callable[[Sequence[Result], Scoring], Groups],
    *,
    quantity: str,
) -> Figure:
    cells = scoring.cells(results)
    by_cell = {cell: groups_of(group, scoring) for cell, group in cells.items()}
    methods = ordered({cell.method for cell in by_cell}, order)
    environments = ordered({cell.environment for cell in by_cell}, order)
    most_groups = max(map(len, by_cell.values()))
    width = max((len(methods) + _GAP) * _BAR, _LEAST_GROUP) * most_groups
    figure, grid = canvas.grid(
        len(environments), 1, panel=(width, _HEIGHT), legend=methods, share_y=False
    )
    looks, handles = styles(methods), {}
    for panel, environment in zip(grid[:, 0], environments, strict=True):
        panel.set_title(f"{environment}, {wording(cells, scoring)}")
        panel.set_ylim(0, 100)
        panel.set_ylabel(quantity)
        panel.grid(visible=False, axis="x")
        names: dict[str, None] = {}
        for offset, method in enumerate(methods):
            groups = by_cell.get(Cell(method, environment))
            if groups is None:
                continue
            names |= dict.fromkeys(groups)
            places = np.arange(len(groups)) * (len(methods) + _GAP) + offset
            handles[method] = _add_bars(panel, places, list(groups.values()), looks[method])
        centres = np.arange(len(names)) * (len(methods) + _GAP) + (len(methods) - 1) / 2
        panel.set_xticks(centres, list(names))
        panel.set_xlim(-_GAP, len(names) * (len(methods) + _GAP) - _GAP)
    canvas.add_remarks(figure, score_remarks(cells, scoring))
    canvas.add_legend(figure, {method: handles[method] for method in methods})
    return figure


def _add_bars(
    panel: Axes,
    places: Float[np.ndarray, "group"],
    estimates: Sequence[Estimate | None],
    look: Style,
) -> BarContainer:
    """A method's bars, one for each group."""
    for place, estimate in zip(places, estimates, strict=True):
        if estimate is None:
            panel.text(place, 0, "–", color=look.color, ha="center", va="bottom")
    shown = [estimate or Estimate(math.nan) for estimate in estimates]
    return panel.bar(
        places,
        [estimate.value for estimate in shown],
        width=0.9,
        yerr=[estimate.deviation or 0.0 for estimate in shown],
        error_kw={"linewidth": 0.8},
        color=look.color,
        hatch=look.hatch,
        edgecolor="white",
    )
