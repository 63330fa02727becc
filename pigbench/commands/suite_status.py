"""`pigbench suite status`: the progress of a suite, read without a simulator."""

import dataclasses
from pathlib import Path

import tyro

from pigbench.report.formats import markdown_grid
from pigbench.suite import spec
from pigbench.suite.status import status, table


@dataclasses.dataclass(frozen=True)
class SuiteStatus:
    """Show the progress of a running, interrupted or finished suite."""

    out: tyro.conf.Positional[Path]
    """Folder of the suite."""

    def run(self) -> None:
        """Print one line per cell."""
        suite = spec.read_kept(self.out / spec.KEPT)
        print(markdown_grid(table(status(suite, self.out))))
