"""Pictures of success rates, of several kinds."""

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
    """Draws a picture into the file `path`, its format told by the extension.

    Names are ordered as in `tables.method_table`. Same results, same bytes. Raises UserError when
    the kind or the format is unknown or the results are not comparable.
    """
    canvas.check_path(path)  # raises before the work rather than after it
    draw = lookup("kind of picture", KINDS, kind)
    with canvas.look():
        canvas.save(draw(results, order, scoring or Scoring()), path)
