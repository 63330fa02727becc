"""`pigbench data`: look at a data set and check it."""

import dataclasses
from pathlib import Path

import tyro

from pigbench.data import dataset, manifest
from pigbench.errors import UserError


@dataclasses.dataclass(frozen=True)
class Info:
    """Say what a data set holds: environment, policy, episodes, observation layout, versions."""

    folder: tyro.conf.Positional[Path]
    """Folder of the data set."""

    def run(self) -> None:
        """Print the summary."""
        print(manifest.describe(manifest.read(self.folder)))


@dataclasses.dataclass(frozen=True)
class Verify:
    """Read every byte of a data set and name each file that is torn, altered or not finite."""

    folder: tyro.conf.Positional[Path]
    """Folder of the data set."""

    def run(self) -> None:
        """Print one line for each thing wrong; raises UserError if there is any."""
        problems = dataset.verify(self.folder)
        for problem in problems:
            print(problem)
        if problems:
            raise UserError(
                f"{self.folder} has {len(problems)} faults; run its `pigbench generate` again"
            )
        print(f"{self.folder} is whole")
