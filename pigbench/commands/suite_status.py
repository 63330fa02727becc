"""`pigbench suite status`: the progress of a suite, read without a simulator."""

import dataclasses
from pathlib import Path

import tyro

from pigbench.report.formats import markdown_grid
from pigbench.suite import spec
from pigbench.suite.spec import Suite
from pigbench.suite.status import status


@dataclasses.dataclass(frozen=True)
class SuiteStatus:
    """Show the progress of a running, interrupted or finished suite."""

    out: tyro.conf.Positional[Path]
    """Folder of the suite."""

    def run(self) -> None:
        """Print one line per cell."""
        print_status(spec.read_kept(self.out / spec.KEPT), self.out)


def print_status(suite: Suite, out: Path) -> None:
    """Print one line per cell of the suite in the folder `out`."""
    lines = [
        (
            cell.name,
            state,
            f"{steps:,} of {cell.environment.steps:,}",
            "" if success is None else f"{success:.1f}",
        )
        for cell, state, steps, success in status(suite, out)
    ]
    print(markdown_grid([("cell", "state", "updates", "success (%)"), *lines]))
