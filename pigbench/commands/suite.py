"""`pigbench suite`: many training runs as one job."""

import dataclasses
import sys
from pathlib import Path
from typing import Annotated

import tyro

from pigbench import devices
from pigbench.cluster import Cluster
from pigbench.commands.parsing import parse
from pigbench.errors import UserError, require
from pigbench.page import make
from pigbench.report.formats import markdown_grid
from pigbench.suite import checks, logs, results, spec, stages
from pigbench.suite.status import status, table
from pigbench.support import cores
from pigbench.support.lock import only_writer

_PAGE = "report"


@dataclasses.dataclass(frozen=True)
class RunSuite:
    """Generate, train, evaluate, tabulate, plot and report everything that a suite file asks for.

    If the command was interrupted, run it again: finished work is skipped, and interrupted work
    continues. A cell that fails does not stop the others.
    """

    file: tyro.conf.Positional[Path]
    """A TOML file, or the name of a suite that comes with pigbench."""
    out: Path
    """Folder of the suite's data, runs, logs, tables, figures and page."""
    jobs: int = cores.available()
    """Training runs at once; if there are several, each gets one processor thread. With --ray, the
    cluster limits them, and this only the evaluations in noise, which this machine does."""
    cluster: Annotated[Cluster, tyro.conf.arg(name="")] = dataclasses.field(default_factory=Cluster)
    """Where shards are simulated and cells are trained."""
    dry_run: bool = False
    """Only print the cells and the time they will take, by rates measured now on this machine."""

    def run(self) -> None:
        """Do the work that is not done yet."""
        from pigbench.suite import estimate

        if self.cluster.ray is None:
            devices.backend()  # raises before anything is made
        require(self, lambda x: x >= 1, "at least 1", "jobs")
        suite = spec.read(self.file)
        trainings = checks.checked_trainings(suite, self.out, parse)
        if self.dry_run:
            times = estimate.estimate(suite, trainings, self.out)
            print(markdown_grid(estimate.table(times, status(suite, self.out))))
            print(f"\n{estimate.summary(times, workers=self.jobs)}")
            return
        with only_writer(self.out):
            spec.write(self.out / spec.KEPT, suite)
            failed = stages.run(suite, self.out, trainings, workers=self.jobs, cluster=self.cluster)
            print(markdown_grid(table(status(suite, self.out))))
            if results.write(suite, self.out):
                print(f"wrote tables and figures to {self.out}")
            _write_page(self.out)
        if failed:
            print(logs.explain(failed, self.out), file=sys.stderr)
            sys.exit(1)


def _write_page(out: Path) -> None:
    try:
        print(f"{make.page([out], out / _PAGE)} shows them")
    except (UserError, OSError) as error:  # the suite is complete without it
        print(f"no page was written: {error}")
