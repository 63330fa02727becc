"""Bar charts: success on each task, a panel an environment."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from pigbench.report import canvas, stats
from pigbench.report.scoring import Scoring, task_success
from pigbench.report.stats import Result
from pigbench.report.styles import style
from pigbench.report.tables import ordered

_HEIGHT = 2.1  # inches
_BAR = 0.11
_LEAST_GROUP = 1.3  # that a task's name has room in
_GAP = 1.0  # bars


def draw(results: Sequence[Result], order: Sequence[str], scoring: Scoring) -> Figure:
    """A bar a method: the mean over seeds, with a whisker of one standard deviation each way."""
    by_cell = {cell: task_success(group, scoring) for cell, group in stats.cells(results).items()}
    methods = ordered({cell.method for cell in by_cell}, order)
    environments = ordered({cell.environment for cell in by_cell}, order)
    most_tasks = max(map(len, by_cell.values()))
    width = max((len(methods) + _GAP) * _BAR, _LEAST_GROUP) * most_tasks
    figure, grid = canvas.grid(
        len(environments), 1, panel=(width, _HEIGHT), legend=methods, share_y=False
    )
    handles = {}
    for panel, environment in zip(grid[:, 0], environments, strict=True):
        panel.set_title(f"{environment}, {scoring.wording}")
        panel.set_ylim(0, 100)
        panel.set_ylabel("success (%)")
        panel.grid(visible=False, axis="x")
        tasks = {}
        for offset, method in enumerate(methods):
            by_task = by_cell.get(stats.Cell(method, environment))
            if by_task is None:
                continue
            tasks |= by_task
            look = style(method)
            handles[method] = panel.bar(
                np.arange(len(by_task)) * (len(methods) + _GAP) + offset,
                [estimate.value for estimate in by_task.values()],
                width=0.9,
                yerr=[estimate.deviation or 0.0 for estimate in by_task.values()],
                error_kw={"linewidth": 0.8},
                color=look.color,
                hatch=look.hatch,
                edgecolor="white",
            )
        centres = np.arange(len(tasks)) * (len(methods) + _GAP) + (len(methods) - 1) / 2
        panel.set_xticks(centres, [name for _, name in tasks])
    canvas.add_legend(figure, {method: handles[method] for method in methods})
    return figure
