"""Figures of success rates, of several kinds."""

import importlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from pigbench.errors import lookup
from pigbench.report import comparison, representations, stats
from pigbench.report.scoring import Cells, Scoring
from pigbench.report.stats import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class PlotKind(NamedTuple):
    """A kind of figure, and the function that draws it.

    Its module in `pigbench.report` imports Matplotlib, and is imported when a figure is drawn.
    """

    about: str
    module: str
    function: str = "draw"
    fits: Callable[[Cells], bool] = lambda cells: True  # whether cells can fill it

    def draw(self, results: Sequence[Result], order: Sequence[str], scoring: Scoring) -> "Figure":
        """The figure. Raises UserError if results cannot fill it."""
        module = importlib.import_module(f"pigbench.report.{self.module}")
        return getattr(module, self.function)(results, order, scoring)


KINDS: Mapping[str, PlotKind] = {
    "curves": PlotKind("over training steps", "curves"),
    "bars": PlotKind("by task", "bars"),
    "box": PlotKind("over environments", "boxes", fits=comparison.has_common_environment),
    "columns": PlotKind(
        "curves by the input of a hierarchy's low level",
        "columns",
        fits=representations.has_low_levels,
    ),
    "profile": PlotKind(
        "shares of runs above each success rate",
        "profiles",
        fits=comparison.has_common_environment,
    ),
    "milestones": PlotKind(
        "how far episodes got, from touching a cube to success", "bars", "draw_milestones"
    ),
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
    from pigbench.report import canvas

    canvas.check_path(path)  # raises before the work, not after it
    draw = lookup("kind of picture", KINDS, kind).draw
    with canvas.look():
        canvas.save(draw(results, order, scoring or Scoring()), path)
