"""Data sets written as OGBench's files."""

import dataclasses
import zipfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import jax.numpy as jnp
import numpy as np

from pigbench.agents.goals import GOALS
from pigbench.agents.representations import Representation
from pigbench.data import shard
from pigbench.data.dataset import ENDINGS, Dataset, Split
from pigbench.data.manifest import ShardRecord
from pigbench.data.ogbench.names import ORACLE_REPS, split_paths
from pigbench.data.shard import FieldArray
from pigbench.errors import UserError, lookup
from pigbench.support import files
from pigbench.support.progress import Progress

Columns = Mapping[str, tuple[str, Callable[[FieldArray], FieldArray]]]
"""For each array in a file: the field from which it is made, and the function that makes it."""


def write(
    dataset: Dataset, path: Path, *, rows_per_file: int | None = None, goals: str = "state"
) -> list[Path]:
    """Write the data set as OGBench's pair of files, each completely or not at all; returns them.

    With `rows_per_file`, they are numbered, F-000.npz and so on, and have at most so many rows, or
    one shard. Unless `goals` is "state", they also contain each row as such a goal. Raises
    UserError if a split is empty, since OGBench's loaders read both, or if they could not compute
    such goals.
    """
    columns = _columns(dataset, goals)
    split_paths(path)
    written = {
        split_paths(path.with_stem(f"{path.stem}{number}"))[name]: part
        for name in ENDINGS
        for number, part in _parts(dataset.split(name), rows_per_file)
    }
    files.require_files(*written)
    total = sum(len(part.records) * len(columns) for part in written.values())
    with Progress("export", total=total, unit="files") as progress:
        for file, part in written.items():
            _write_file(file, part, columns, progress)
    return list(written)


def _parts(split: Split, rows_per_file: int | None) -> Iterator[tuple[str, Split]]:
    """Yield the endings of numbered files and the shards of each."""
    if rows_per_file is None:
        yield "", split
        return
    parts: list[list[ShardRecord]] = [[]]
    for record in split.records:
        if parts[-1] and sum(one.rows for one in parts[-1]) + record.rows > rows_per_file:
            parts.append([])
        parts[-1].append(record)
    for number, records in enumerate(parts):
        yield f"-{number:03d}", dataclasses.replace(split, records=tuple(records))


def _columns(dataset: Dataset, goals: str) -> Columns:
    lookup("goals", GOALS, goals)
    columns: Columns = {field: (field, np.ascontiguousarray) for field in dataset.spec.fields}
    if goals == "state":
        return columns
    if "qpos" not in columns:
        raise UserError(f"{dataset.folder} has no qpos, of which OGBench's loader makes such goals")
    represent = Representation(goals, dataset.layout, table=GOALS)
    return {
        **columns,
        ORACLE_REPS: ("observations", lambda rows: np.asarray(represent(jnp.asarray(rows)))),
    }


def _write_file(path: Path, split: Split, columns: Columns, progress: Progress) -> None:
    with files.replacing_file(path) as file, zipfile.ZipFile(file, "w") as archive:
        for name, (field, make) in columns.items():
            first = make(split.shard(split.records[0], field))
            header = np.lib.format.header_data_from_array_1_0(first)
            header["shape"] = (split.rows, *first.shape[1:])
            with archive.open(shard.file_name(name), "w", force_zip64=True) as member:
                np.lib.format.write_array_header_1_0(member, header)
                for record in split.records:
                    member.write(make(split.shard(record, field)).data)
                    progress.advance(1, path.name)
