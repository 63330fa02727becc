"""The tables and figures that a suite ends with."""

import itertools
from collections.abc import Iterable
from pathlib import Path

from pigbench.report import order, stats, tables
from pigbench.report.stats import Result
from pigbench.suite.spec import Suite
from pigbench.suite.status import DONE, status
from pigbench.support import files
from pigbench.training.run import read_run

_FORMATS = {"markdown": "md", "latex": "tex", "csv": "csv"}


def write(suite: Suite, out: Path) -> bool:
    """Write tables and figures of the finished cells to `out`; whether there are any."""
    runs = [out / one.cell.name for one in status(suite, out) if one.state == DONE]
    if not runs:
        return False
    from pigbench.report import plots  # imports Matplotlib, which takes long

    results = stats.read_results(read_run(run) for run in runs)
    telling = tables.telling(results)
    made = [tables.TABLES[name](results, order=order.registered()) for name in telling]
    for style, extension in _FORMATS.items():
        files.write_text(out / f"tables.{extension}", tables.render_all(made, style))
    fits = {
        "columns": _has_low_levels(results),
        **dict.fromkeys(("box", "profile"), "aggregate" in telling),
    }
    kinds = [kind for kind in plots.KINDS if fits.get(kind, True)]
    for kind, extension in itertools.product(kinds, ("png", "pdf")):
        plots.plot(results, out / f"{kind}.{extension}", kind=kind, order=order.registered())
    return True


def _has_low_levels(results: Iterable[Result]) -> bool:
    return any(result.representation is not None for result in results)
