"""Performance profiles: the share of runs with success above a threshold, for every threshold."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from pigbench.report import canvas, comparison
from pigbench.report.order import ordered
from pigbench.report.scoring import Scoring, score_remarks, wording
from pigbench.report.stats import Result
from pigbench.report.styles import styles

_PANEL = 5.8, 3.2
_MARK_EVERY = 20  # thresholds
_THRESHOLDS = np.arange(0.0, 100.5, 0.5)


def draw(results: Sequence[Result], order: Sequence[str], scoring: Scoring) -> Figure:
    """One line per method, in its bootstrap band, over the environments that all methods have."""
    cells = comparison.common(scoring.cells(results))
    pooled = comparison.pool(cells, scoring)
    profiles = comparison.profiles(pooled, _THRESHOLDS, scoring)
    methods = ordered(profiles, order)
    figure, grid = canvas.grid(1, 1, panel=_PANEL, legend=methods)
    panel = grid[0, 0]
    looks, handles = styles(methods), {}
    for method in methods:
        look = looks[method]
        share, band = profiles[method]
        (handles[method],) = panel.step(
            _THRESHOLDS,
            share,
            look.line,
            color=look.color,
            marker=look.marker,
            markevery=_MARK_EVERY,
            where="post",
        )
        if band is not None:
            panel.fill_between(
                _THRESHOLDS, *band, step="post", color=look.color, alpha=0.15, linewidth=0
            )
    panel.set_xlim(0, 100)
    panel.set_ylim(0, 100)
    environments = ", ".join(ordered(pooled.environments, order))
    panel.set_title(canvas.wrapped(environments, _PANEL[0]))
    panel.set_xlabel(f"threshold: success (%), {wording(cells, scoring)}")
    panel.set_ylabel("runs above the threshold (%)")
    canvas.add_remarks(figure, score_remarks(cells, scoring))
    canvas.add_legend(figure, handles)
    return figure
