"""`pigbench data`: look at a data set, check it, exchange it with other formats."""

import dataclasses
import importlib
from pathlib import Path
from shlex import quote

import tyro

from pigbench.data import dataset, manifest
from pigbench.errors import UserError, lookup

_FORMATS = {"ogbench": "pigbench.data.ogbench"}
"""Modules, imported when they are needed: looking at a data set takes no simulator."""


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
                f"{self.folder} has {len(problems)} faults; run the command that made it again"
            )
        print(f"{self.folder} is whole")


@dataclasses.dataclass(frozen=True)
class Export:
    """Write a data set in another format: for OGBench's loaders, F.npz and F-val.npz."""

    folder: tyro.conf.Positional[Path]
    """Folder of the data set."""
    out: Path
    """File of the training split; that of the validation split is named after it."""
    rows_per_file: int | None = None
    """Rows of a file at most, as whole shards; by default a split is one file."""
    format: str = "ogbench"
    """Format of the files."""
    goals: str = "state"
    """cubes to have each row's cube positions too, as OGBench's `-oraclerep` environments."""

    def run(self) -> None:
        """Write the files."""
        form = importlib.import_module(lookup("format", _FORMATS, self.format))
        data = dataset.load(self.folder)
        written = form.write(data, self.out, rows_per_file=self.rows_per_file, goals=self.goals)
        print(f"{' and '.join(map(str, written))} are written")


@dataclasses.dataclass(frozen=True)
class Import:
    """Make a data set of OGBench's files, or of what `pigbench data export` wrote.

    The files of validation, F-val.npz beside F.npz, are read too.

    Run the same command again after it was cut off: finished shards are kept.
    """

    files: tyro.conf.Positional[tuple[Path, ...]]
    """Files of the training split, or a folder of them."""
    environment: str
    """Environment that the data is from; see `pigbench list envs`."""
    out: Path
    """Folder of the data set."""
    physics: str = "exact"
    """Physics profile in which policies trained on the data are evaluated."""
    format: str = "ogbench"
    """Format of the files."""

    def run(self) -> None:
        """Import what is missing."""
        form = importlib.import_module(lookup("format", _FORMATS, self.format))
        form.read(self.files, environment=self.environment, physics=self.physics, folder=self.out)
        print(f"{self.out} is complete; see it with: pigbench data info {quote(str(self.out))}")
