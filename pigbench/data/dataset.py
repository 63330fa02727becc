"""Reading an offline data set: a folder with a manifest and one folder per shard."""

import dataclasses
import itertools
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from jaxtyping import Int

from pigbench.data import manifest, shard
from pigbench.data.manifest import Manifest, ShardRecord, Spec
from pigbench.data.mapped import MappedArray
from pigbench.data.shard import FieldArray
from pigbench.errors import UserError, lookup
from pigbench.layout import Layout
from pigbench.support import files

_REPEAT = "run the same `pigbench generate` again (or `pigbench data import`, or `data filter`)"

ENDINGS = {"train": "", "val": "-val"}
"""Of a split's name in the formats of other libraries."""


@dataclasses.dataclass(frozen=True)
class Split:
    """The shards of one split of a data set."""

    folder: Path
    spec: Spec
    records: tuple[ShardRecord, ...]

    @property
    def rows(self) -> int:
        """The number of rows of all shards together."""
        return sum(record.rows for record in self.records)

    @property
    def episode_ends(self) -> Int[np.ndarray, "episode"]:
        """Each episode's last row; reads no file if all episodes are equally long."""
        length = self.spec.rows_per_episode
        if not length:
            return np.flatnonzero(self.concatenate("terminals"))
        return np.arange(length, self.rows + 1, length) - 1

    def shard(self, record: ShardRecord, field: str) -> FieldArray:
        """The field of one shard, memory-mapped and read-only: an open file as long as it lives."""
        lookup("field", dict.fromkeys(self.spec.fields), field)
        return shard.read(self.folder, record, field)

    def shards(self, field: str) -> list[FieldArray]:
        """The field of every shard at once, each as by `shard`."""
        files.allow_many_open()
        return [self.shard(record, field) for record in self.records]

    def mapped(self, field: str) -> MappedArray:
        """The field of all shards, (rows, ...), of which only the requested rows are read."""
        paths = [self.folder / record.name / shard.file_name(field) for record in self.records]
        return MappedArray(self.shards(field), paths)

    def shard_episodes(self, record: ShardRecord, *fields: str) -> Iterator[dict[str, FieldArray]]:
        """Yield the fields of each episode of a shard of the split, memory-mapped."""
        arrays = {field: self.shard(record, field) for field in fields}
        ends = np.flatnonzero(self.shard(record, "terminals")) + 1
        for start, stop in itertools.pairwise([0, *ends]):
            yield {field: array[start:stop] for field, array in arrays.items()}

    def concatenate(self, field: str) -> FieldArray:
        """The field of all shards in memory. Raises UserError if it contains NaN."""
        arrays = self.shards(field)
        for record, array in zip(self.records, arrays, strict=True):
            problem = shard.field_problem(self.spec, field, array, rows=record.rows)
            if problem is not None:
                path = self.folder / record.name / shard.file_name(field)
                raise UserError(f"{path} {problem}")
        return np.concatenate(arrays)


@dataclasses.dataclass(frozen=True)
class Dataset:
    """A complete data set, opened for reading."""

    folder: Path
    manifest: Manifest

    @property
    def spec(self) -> Spec:
        """The specification that identifies the data."""
        return self.manifest.spec

    @property
    def layout(self) -> Layout:
        """The terms of its observations."""
        return self.spec.layout

    @property
    def digest(self) -> str:
        """The SHA-256 of the manifest, and thus of all the data."""
        return manifest.digest(self.folder)

    @property
    def splits(self) -> dict[str, Split]:
        """The splits that hold rows, by name."""
        held = dict.fromkeys(record.split for record in self.manifest.shards if record.rows)
        return {name: self.split(name) for name in held}

    def split(self, name: str) -> Split:
        """The split `name`. Raises UserError if it does not exist or is empty."""
        lookup("split", self.spec.episodes, name)
        records = tuple(record for record in self.manifest.shards if record.split == name)
        if not any(record.rows for record in records):
            raise UserError(f"{self.folder} holds no {name} episodes")
        return Split(self.folder, self.spec, records)

    def episode(self, split: str, number: int, field: str) -> FieldArray:
        """The field of an episode of a split, counted from 0. Raises UserError if there is none."""
        opened = self.split(split)
        ends = opened.episode_ends
        if not 0 <= number < len(ends):
            raise UserError(
                f"episode is {number}: {self.folder} has {split} episodes 0 to {len(ends) - 1}"
            )
        first = ends[number - 1] + 1 if number else 0
        return opened.mapped(field)[first : ends[number] + 1]


def load(folder: Path) -> Dataset:
    """Open the data set in `folder`.

    Raises UserError if there is none, if it is unfinished, or if a file is missing or of the wrong
    size. `verify` checks the content too.
    """
    remaining = manifest.remaining(folder)
    if remaining is not None:
        raise UserError(f"{folder} is unfinished: {remaining}; {_REPEAT} to finish it")
    content = manifest.read(folder)
    for record in content.shards:
        for path, problem in shard.file_problems(folder, record):
            raise UserError(f"{path} {problem}; {_REPEAT} to mend it")
    return Dataset(folder, content)


def verify(folder: Path) -> list[str]:
    """Read every byte of the data set in `folder`; returns one line per problem, with its file.

    Raises UserError if there is no readable manifest.
    """
    content = manifest.read(folder)
    unfinished = [f"{folder / part.name} is missing" for part in content.missing()]
    if not unfinished and (remaining := manifest.remaining(folder)):
        unfinished = [f"{folder} is unfinished: {remaining}"]
    found = itertools.chain.from_iterable(
        _shard_problems(folder, content.spec, record) for record in content.shards
    )
    return unfinished + [f"{path} {problem}" for path, problem in found]


def check_layout(dataset: Dataset, layout: Layout) -> None:
    """Raise UserError unless the observations have the environment's `layout`."""
    pairs = itertools.zip_longest(dataset.layout.terms, layout.terms)
    for number, (stored, expected) in enumerate(pairs):
        if stored != expected:
            raise UserError(
                f"{dataset.folder} does not fit the environment: term {number} of an observation "
                f"is {_term(stored)} in the data and {_term(expected)} in the environment"
            )


def _term(term: tuple[str, int] | None) -> str:
    return f"{term[0]!r} of size {term[1]}" if term else "nothing"


def _shard_problems(folder: Path, spec: Spec, record: ShardRecord) -> Iterator[tuple[Path, str]]:
    torn = dict(shard.file_problems(folder, record))
    yield from torn.items()
    for field in spec.fields:
        name = shard.file_name(field)
        path = folder / record.name / name
        if path in torn:
            continue
        if files.sha256(path) != record.files[name].sha256:
            yield path, "is altered: its SHA-256 is not the manifest's"
            continue
        array = shard.read(folder, record, field)
        problem = shard.field_problem(spec, field, array, rows=record.rows)
        if problem is not None:
            yield path, problem
