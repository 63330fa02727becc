"""Figures of success rates, of several kinds."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from matplotlib.figure import Figure

from pigbench.errors import lookup
from pigbench.report import bars, boxes, canvas, columns, curves, profiles
from pigbench.report.scoring import Scoring
from pigbench.report.stats import Result

KINDS: Mapping[str, Callable[[Sequence[Result], Sequence[str], Scoring], Figure]] = {
    "curves": curves.draw,
    "bars": bars.draw,
    "box": boxes.draw,
    "columns": columns.draw,
    "profile": profiles.draw,
    "milestones": bars.draw_milestones,
}


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
    draw = lookup("kind of picture", KINDS, kind)
    with canvas.look():
        canvas.save(draw(results, order, scoring or Scoring()), path)
