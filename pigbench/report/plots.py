"""Figures of success rates, of several kinds."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from matplotlib.figure import Figure

from pigbench.errors import lookup
from pigbench.report import bars, boxes, canvas, columns, comparison, curves, profiles, stats
from pigbench.report.scoring import Cells, Scoring
from pigbench.report.stats import Result


class PlotKind(NamedTuple):
    """A kind of figure: the function that draws it of results, and whether cells can fill it."""

    draw: Callable[[Sequence[Result], Sequence[str], Scoring], Figure]
    fits: Callable[[Cells], bool] = lambda cells: True


KINDS: Mapping[str, PlotKind] = {
    "curves": PlotKind(curves.draw),
    "bars": PlotKind(bars.draw),
    "box": PlotKind(boxes.draw, comparison.has_common_environment),
    "columns": PlotKind(columns.draw, columns.has_low_levels),
    "profile": PlotKind(profiles.draw, comparison.has_common_environment),
    "milestones": PlotKind(bars.draw_milestones),
}


def fillable(results: Sequence[Result]) -> list[str]:
    """The names of the `KINDS` that results can fill."""
    cells = stats.cells(results)
    return [name for name, kind in KINDS.items() if kind.fits(cells)]


def plot(
    results: Sequence[Result],
    path: Path,
    *,
    kind: str = "curves",
    order: Sequence[str] = (),
    scoring: Scoring | None = None,
) -> None:
    """Draw a figure into the file `path`, in the format of its extension.

    Names are ordered by `order.ordered`. Same results, same bytes. Raises UserError if
    the kind or the format is unknown or the results are not comparable.
    """
    canvas.check_path(path)  # raises before the work, not after it
    draw = lookup("kind of picture", KINDS, kind).draw
    with canvas.look():
        canvas.save(draw(results, order, scoring or Scoring()), path)
