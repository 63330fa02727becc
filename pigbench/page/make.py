"""Making a page, if the packages that it needs are installed."""

from collections.abc import Sequence
from pathlib import Path

from pigbench.page import place
from pigbench.report import order
from pigbench.report.scoring import Scoring
from pigbench.support.extras import required


def page(folders: Sequence[Path], out: Path, scoring: Scoring | None = None) -> Path:
    """Write the page of runs and suites into the folder `out`; returns its file.

    Raises UserError like `page.write`, and if a package is missing.
    """
    place.require_own(out)  # before the work, not after it
    required("bokeh", "jinja2", extra="report")
    from pigbench.page.page import write

    return write(folders, out, order=order.registered(), scoring=scoring)
