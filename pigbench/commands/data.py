"""`pigbench data`: inspect and check a data set, and convert it from and to other formats."""

import dataclasses
from pathlib import Path
from typing import Annotated

import tyro

from pigbench.data import dataset, formats, hub, manifest, selection
from pigbench.data.quality import CRITERIA, Limits
from pigbench.errors import UserError, require
from pigbench.report.formats import markdown_grid
from pigbench.sharing import card
from pigbench.sharing import data as sharing
from pigbench.support import files, typed


@dataclasses.dataclass(frozen=True)
class DataInfo:
    """Describe a data set: environment, policy, episodes, observation layout, versions."""

    folder: tyro.conf.Positional[Path]
    """Folder of the data set."""

    def run(self) -> None:
        """Print the summary."""
        print(manifest.describe(manifest.read(self.folder)))


@dataclasses.dataclass(frozen=True)
class DataVerify:
    """Read every byte of a data set, and list files that are truncated, altered or not finite."""

    folder: tyro.conf.Positional[Path]
    """Folder of the data set."""

    def run(self) -> None:
        """Print one line per problem; raises UserError if there is any."""
        problems = dataset.verify(self.folder)
        for problem in problems:
            print(problem)
        if problems:
            raise UserError(
                f"{self.folder} has {len(problems)} faults; run the command that made it again"
            )
        print(f"{self.folder} is intact")


@dataclasses.dataclass(frozen=True)
class DataFilter:
    """Make a data set from the good episodes of another, and report which were left out and why.

    Each episode is judged by its own observations, as in a robot's log. The measurements of those
    left out are in the new data set's file filter.json.
    """

    folder: tyro.conf.Positional[Path]
    """Folder of the data set."""
    out: Path
    """Folder of the new data set."""
    criteria: tuple[str, ...] = tuple(CRITERIA)
    """Criteria for episodes: success (the cube was at the goal, and elsewhere), jerk, length,
    drops."""
    limits: Annotated[Limits, tyro.conf.arg(name="")] = dataclasses.field(default_factory=Limits)
    """Limits of the criteria."""

    def run(self) -> None:
        """Judge the episodes, write the good ones and report."""
        data = dataset.load(self.folder)
        judged = selection.judge(data, self.criteria, self.limits)
        print(markdown_grid(selection.table(judged, self.criteria, self.limits)))
        print(f"\n{selection.summary(judged)}")
        selection.write(data, self.out, judged, self.criteria, self.limits)
        selection.write_report(self.out, data, judged, self.limits)
        print(typed.complete(self.out, seen_by="data info"))


@dataclasses.dataclass(frozen=True)
class DataExport:
    """Write a data set in another format.

    For OGBench's loaders, the output is F.npz and F-val.npz; for Minari, a folder that
    MINARI_DATASETS_PATH can point to; for LeRobot, the folder of a version 3 data set.
    """

    folder: tyro.conf.Positional[Path]
    """Folder of the data set."""
    out: Path
    """File for the training split (the validation split's is named after it), or a folder."""
    rows_per_file: int | None = None
    """Maximum rows per OGBench file, in whole shards; by default each split is one file."""
    format: str = "ogbench"
    """Format: ogbench, minari or lerobot."""
    goals: str = "state"
    """state, or cubes to add each row's cube positions, as in OGBench's `-oraclerep` data."""

    def __post_init__(self) -> None:
        require(self, lambda x: x is None or x >= 1, "at least 1", "rows_per_file")

    def run(self) -> None:
        """Write the files."""
        asked = {"rows_per_file": self.rows_per_file, "goals": self.goals}
        options = {name: it for name, it in asked.items() if it != getattr(type(self), name)}
        write = formats.writer(self.format, options)
        written = write(dataset.load(self.folder), self.out)
        verb = "is" if len(written) == 1 else "are"
        print(f"{' and '.join(map(str, written))} {verb} written")


@dataclasses.dataclass(frozen=True)
class DataCard:
    """Write a data set's README: its contents and how to load it, with the hub's header."""

    folder: tyro.conf.Positional[Path]
    """Folder of the data set."""
    license: str = card.LICENSE
    """Licence of the data, as named on the hub."""

    def run(self) -> None:
        """Write the file."""
        print(f"{sharing.write(dataset.load(self.folder), license=self.license)} is written")


@dataclasses.dataclass(frozen=True)
class DataPush:
    """Put a data set into a repository of the Hugging Face hub, with its card.

    Log in with `hf auth login`, or set HF_TOKEN. If the command was interrupted, run it again:
    files that are already there are not sent again.
    """

    repository: tyro.conf.Positional[str]
    """Repository as owner/name; it is created if it does not exist."""
    data: Path
    """Folder of the data set."""
    private: bool = False
    """Create a repository that others cannot see; an existing one stays as it is."""
    license: str = card.LICENSE
    """Licence for the card, if there is no card yet."""

    def run(self) -> None:
        """Write the card if there is none, and send everything."""
        data = dataset.load(self.data)
        if not (self.data / card.FILE_NAME).exists():
            sharing.write(data, license=self.license)
        print(f"{self.data} is at {hub.push(data, self.repository, private=self.private)}")


@dataclasses.dataclass(frozen=True)
class DataPull:
    """Fetch a data set from a repository of the Hugging Face hub, and verify every byte.

    If the command was interrupted, run it again: files already there are not fetched again.
    """

    repository: tyro.conf.Positional[str]
    """Repository as owner/name."""
    out: Path
    """Folder of the data set."""
    revision: str | None = None
    """Branch, tag or commit; by default the main branch."""

    def run(self) -> None:
        """Fetch what is missing."""
        files.require_folder(self.out)
        hub.pull(self.repository, self.out, revision=self.revision)
        print(typed.complete(self.out, seen_by="data info"))


@dataclasses.dataclass(frozen=True)
class DataImport:
    """Make a data set from files of OGBench or `pigbench data export`, or from a robot's logs.

    Validation files, F-val.npz beside F.npz, are read too. Logs are one file per episode, or a
    LeRobot v3 folder of a UR5e; docs/robot.md lists the required columns and their units.

    If the command was interrupted, run it again: finished shards are kept.
    """

    files: tyro.conf.Positional[tuple[Path, ...]]
    """Files of the training split, or a folder of them. Every tenth log is used for validation."""
    environment: str
    """Environment that the data come from; see `pigbench list envs`."""
    out: Path
    """Folder of the data set."""
    physics: str = "exact"
    """Physics profile for evaluating policies trained on the data."""
    format: str = "ogbench"
    """Format of the files: ogbench or log."""

    def run(self) -> None:
        """Import what is missing."""
        if not self.files:
            raise UserError("no files are given: name those of the training split, or a folder")
        read = formats.reader(self.format)
        read(self.files, environment=self.environment, physics=self.physics, folder=self.out)
        print(typed.complete(self.out, seen_by="data info"))
