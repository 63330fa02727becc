"""Learning curves: success over training steps, one panel per environment."""

import itertools
from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pigbench.report import canvas, stats
from pigbench.report.order import ordered
from pigbench.report.scoring import Scoring, curve_remarks
from pigbench.report.stats import Estimate, Result
from pigbench.report.styles import Style, styles

_PANEL = 3.2, 2.5
_COLUMNS = 3


def draw(results: Sequence[Result], order: Sequence[str], scoring: Scoring) -> Figure:
    """One line per method: the mean over seeds, in a band of one standard deviation each way."""
    cells = scoring.cells(results)
    methods = ordered({cell.method for cell in cells}, order)
    environments = ordered({cell.environment for cell in cells}, order)
    columns = min(len(environments), _COLUMNS)
    rows = -(-len(environments) // columns)
    figure, grid = canvas.grid(rows, columns, panel=_PANEL, legend=methods)
    looks, lines = styles(methods), {}
    for panel, environment in zip(grid.flat, environments, strict=False):
        prepare(panel)
        panel.set_title(environment)
        for method in methods:
            group = cells.get(stats.Cell(method, environment))
            if group:
                lines[method] = add_curve(panel, stats.success_curve(group), looks[method])
    for panel in grid.flat[len(environments) :]:
        panel.set_axis_off()
    for panel in grid[:, 0]:
        panel.set_ylabel("success (%)")
    canvas.add_remarks(figure, curve_remarks(itertools.chain.from_iterable(cells.values())))
    canvas.add_legend(figure, {method: lines[method] for method in methods})
    return figure


def prepare(panel: Axes) -> None:
    """Set up the axes of a learning curve."""
    panel.set_ylim(0, 100)
    canvas.step_axis(panel)


def add_curve(panel: Axes, curve: Mapping[int, Estimate], look: Style) -> Line2D:
    """Draw means by training step, in a band of one standard deviation to each side."""
    steps = list(curve)
    means = [estimate.value for estimate in curve.values()]
    deviations = [estimate.deviation or 0.0 for estimate in curve.values()]
    # Markers, because a curve of one evaluation has no line.
    (line,) = panel.plot(
        steps, means, look.line, color=look.color, marker=look.marker, clip_on=False
    )
    lower = [mean - deviation for mean, deviation in zip(means, deviations, strict=True)]
    upper = [mean + deviation for mean, deviation in zip(means, deviations, strict=True)]
    panel.fill_between(steps, lower, upper, color=look.color, alpha=0.15, linewidth=0)
    return line
