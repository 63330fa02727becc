"""One shard of a data set: a folder with one `.npy` file per field, with rows of whole episodes.

`terminals` is true on an episode's last row; where it is false, rows i and i + 1 are a transition.
"""

import errno
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from jaxtyping import Shaped

from pigbench.data.manifest import FileRecord, Shard, ShardRecord, Spec
from pigbench.errors import UserError
from pigbench.support import files

FieldArray = Shaped[np.ndarray, "_ ..."]
"""A field of some rows."""

DTYPES = {
    "observations": np.dtype(np.float32),
    "actions": np.dtype(np.float32),
    "terminals": np.dtype(np.bool_),
    "qpos": np.dtype(np.float32),
    "qvel": np.dtype(np.float32),
}

IMPORTED_EPISODES = 1000
"""The most episodes of a shard of imported data: as many as in OGBench's files."""


def file_name(field: str) -> str:
    """The file of `field` in a shard's folder."""
    return f"{field}.npy"


def write(
    folder: Path, spec: Spec, shard: Shard, arrays: Mapping[str, FieldArray], *, dropped: int
) -> ShardRecord:
    """Write the shard's folder into `folder`, completely or not at all, and return its record.

    `arrays` contains each field of the specification for `shard.episodes - dropped` episodes.
    Raises ValueError if it does not match the specification.
    """
    episodes = shard.episodes - dropped
    if set(arrays) != set(spec.fields):
        raise ValueError(f"{shard.name} has fields {sorted(arrays)}, not {sorted(spec.fields)}")
    rows = episodes * spec.rows_per_episode or len(arrays["terminals"])
    for field, array in arrays.items():
        problem = field_problem(spec, field, array, rows=rows)
        if problem is not None:
            raise ValueError(f"{field} of {shard.name} {problem}")
    if np.sum(arrays["terminals"]) != episodes:
        raise ValueError(f"terminals of {shard.name} do not end {episodes} episodes")
    with files.replacing_folder(folder / shard.name) as new:
        for field in spec.fields:
            _write_array(new / file_name(field), arrays[field])
        records = {file_name(field): FileRecord.of(new / file_name(field)) for field in spec.fields}
    return ShardRecord(shard.name, shard.split, episodes, dropped, rows, records)


def read(folder: Path, record: ShardRecord, field: str) -> FieldArray:
    """The array of `field`, memory-mapped and read-only. Raises UserError if it is torn."""
    path = folder / record.name / file_name(field)
    try:
        return np.load(path, mmap_mode="r")
    except (OSError, ValueError, EOFError) as error:
        if getattr(error, "errno", None) == errno.EMFILE:
            raise UserError(f"{path} is one open file too many: raise `ulimit -n`") from None
        raise UserError(f"{path} is torn: no array can be read from it") from None


def file_problems(folder: Path, record: ShardRecord) -> Iterator[tuple[Path, str]]:
    """Yield each file of the shard that is missing or has the wrong size, with the problem."""
    for name, expected in record.files.items():
        path = folder / record.name / name
        if not path.is_file():
            yield path, "is missing"
        elif path.stat().st_size != expected.bytes:
            yield path, f"is torn: {path.stat().st_size} bytes instead of {expected.bytes}"


def field_problem(spec: Spec, field: str, array: FieldArray, *, rows: int) -> str | None:
    """The problem with `array` as the `field` of a shard of `rows` rows; None if there is none."""
    row_shapes = {
        "observations": (spec.layout.size,),
        "actions": (spec.action_size,),
        "terminals": (),
    }
    shape = (rows, *row_shapes.get(field, array.shape[1:]))
    if array.dtype != DTYPES[field]:
        return f"has type {array.dtype} instead of {DTYPES[field]}"
    if array.shape != shape:
        return f"has shape {array.shape} instead of {shape}"
    if field == "terminals":
        length = spec.rows_per_episode or rows
        last_rows = np.arange(1, rows + 1) % length == 0
        # Where lengths differ, only the last row is known to end an episode.
        bad = (array != last_rows) & (last_rows | (spec.rows_per_episode > 0))
        complaint = f"does not end an episode every {length} rows"
    else:
        bad = ~np.isfinite(array).all(axis=tuple(range(1, array.ndim)))
        complaint = "holds NaN or infinity"
    return f"{complaint} (first in row {bad.argmax()})" if bad.any() else None


def _write_array(path: Path, array: FieldArray) -> None:
    # Not np.save: on a full disk it raises an OSError without an errno.
    array = np.ascontiguousarray(array)
    with open(path, "wb") as file:
        header = np.lib.format.header_data_from_array_1_0(array)
        np.lib.format.write_array_header_1_0(file, header)
        file.write(array.data)
