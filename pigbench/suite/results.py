"""The tables and figures that a suite ends with."""

import itertools
from pathlib import Path

from pigbench.report import order, plots, stats, tables
from pigbench.runs.run import read_run
from pigbench.suite.spec import Suite
from pigbench.suite.status import DONE, status
from pigbench.support import files

_FORMATS = {"markdown": "md", "latex": "tex", "csv": "csv"}


def write(suite: Suite, out: Path) -> bool:
    """Write tables and figures of the finished cells to `out`; whether there are any."""
    runs = [out / one.cell.name for one in status(suite, out) if one.state == DONE]
    if not runs:
        return False
    results = stats.read_results(read_run(run) for run in runs)
    made = [
        tables.TABLES[name].make(results, order=order.registered())
        for name in tables.fillable(results)
    ]
    for style, extension in _FORMATS.items():
        files.write_text(out / f"tables.{extension}", tables.render_all(made, style))
    for kind, extension in itertools.product(plots.fillable(results), ("png", "pdf")):
        plots.plot(results, out / f"{kind}.{extension}", kind=kind, order=order.registered())
    return True
