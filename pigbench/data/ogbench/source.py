"""One of OGBench's files, read in pieces."""

import contextlib
import itertools
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO

import numpy as np
from jaxtyping import Int

from pigbench import envs
from pigbench.data import collect, shard
from pigbench.data.ogbench.names import NEXT, VALIDS
from pigbench.data.shard import IMPORTED_EPISODES, FieldArray
from pigbench.errors import UserError
from pigbench.support import files

_READ_HEADER = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}


class Source:
    """One of the files.

    Attributes:
        fields: the fields of a shard that it contains.
        lengths: the rows of each episode, (episodes,), including its last state.

    Raises UserError if it is torn or its arrays do not have the environment's shapes.
    """

    def __init__(self, path: Path, env: "envs.CubeEnv") -> None:
        self.path = path
        if not path.is_file():
            raise UserError(f"{path} does not exist")
        with self._archive() as archive:
            self._stored = {name.removesuffix(".npy") for name in archive.namelist()}
        # Where rows are transitions, an episode's last state has no position and velocity.
        self._transitions = NEXT in self._stored
        kept = ("observations", "actions") if self._transitions else tuple(shard.DTYPES)
        ending = VALIDS if VALIDS in self._stored else "terminals"
        for field in ("observations", "actions", ending):
            if field not in self._stored:
                raise UserError(f"{path} has no {field}")
        self.fields = tuple(
            field
            for field in shard.DTYPES
            if field == "terminals" or field in self._stored & {*kept}
        )
        self._check_shapes(env)
        (ends,) = self._pieces(ending, [self._stored_rows])
        ends = np.flatnonzero(ends == (ending != VALIDS))
        self._stored_lengths = np.diff(ends, prepend=-1)
        if not len(ends):
            raise UserError(f"{path} has no whole episode: its {ending} tell of no last row")
        if ends[-1] != self._stored_rows - 1:
            raise UserError(
                f"{path} ends within an episode: the last whole one ends in row {ends[-1]}"
            )
        self.lengths = self._stored_lengths + self._transitions

    @property
    def rows(self) -> int:
        """The number of rows of all episodes."""
        return int(self.lengths.sum())

    @property
    def sha256(self) -> str:
        """The file's SHA-256."""
        return files.sha256(self.path)

    def pieces(self) -> list[int]:
        """The number of episodes in each shard that is made from the file."""
        starts = range(0, len(self.lengths), IMPORTED_EPISODES)
        return [min(IMPORTED_EPISODES, len(self.lengths) - start) for start in starts]

    def _check_shapes(self, env: "envs.CubeEnv") -> None:
        """Raise UserError unless all arrays have the environment's shapes. Reads headers only."""
        row_shapes = collect.row_shapes(env)
        row_shapes |= {NEXT: row_shapes["observations"], VALIDS: ()}
        shapes = {field: self._shape(field) for field in row_shapes if field in self._stored}
        self._stored_rows = next((shape[0] for shape in shapes.values() if shape), 0)
        for field, shape in shapes.items():
            expected = (self._stored_rows, *row_shapes[field])
            if shape != expected:
                raise UserError(
                    f"{self.path} does not fit {env.spec.name}: {field} has shape {shape} instead "
                    f"of {expected}"
                )

    def read(self, fields: Sequence[str]) -> Iterator[dict[str, FieldArray]]:
        """Yield the fields of each piece, in the types of our shards."""
        bounds = np.cumsum([0, *self.pieces()])
        pieces = [self._stored_lengths[start:stop] for start, stop in itertools.pairwise(bounds)]
        counts = [int(piece.sum()) for piece in pieces]
        names = [field for field in fields if field != "terminals"]
        names += [NEXT] if self._transitions else []
        arrays = {name: self._pieces(name, counts) for name in names}
        for piece in pieces:
            content = {name: next(array) for name, array in arrays.items()}
            ends = np.cumsum(piece) - 1
            if self._transitions:
                content = self._with_last_states(content, ends)
                ends = np.cumsum(piece + 1) - 1
            terminals = np.zeros(len(content["actions"]), bool)
            terminals[ends] = True
            yield {field: {**content, "terminals": terminals}[field] for field in fields}

    def _with_last_states(
        self, content: Mapping[str, FieldArray], ends: Int[np.ndarray, "episode"]
    ) -> dict[str, FieldArray]:
        """Convert rows of transitions to rows of states; an episode's last state has no action."""
        observations, after = content["observations"], content[NEXT]
        same = (observations[1:] == after[:-1]).all(axis=1)
        same[ends[:-1]] = True
        if not same.all():
            raise UserError(
                f"{self.path}: {NEXT} are not the observations of the next row (first in row "
                f"{same.argmin()} of a piece)"
            )
        return {
            "observations": np.insert(observations, ends + 1, after[ends], axis=0),
            "actions": np.insert(content["actions"], ends + 1, 0, axis=0),
        }

    def _pieces(self, field: str, counts: Iterable[int]) -> Iterator[FieldArray]:
        """Yield the array in pieces of the given numbers of rows, in the type of our shards."""
        like = "observations" if field == NEXT else "terminals" if field == VALIDS else field
        with self._archive() as archive, archive.open(shard.file_name(field)) as file:
            (length, *row_shape), dtype, by_column = _read_header(file)
            if by_column:  # no row is complete before the end
                data = np.frombuffer(_read(file, (length, *row_shape), dtype), dtype)
                whole = data.reshape((length, *row_shape), order="F")
                bounds = itertools.pairwise(itertools.accumulate(counts, initial=0))
                parts = (whole[start:stop] for start, stop in bounds)
            else:
                shapes = ((rows, *row_shape) for rows in counts)
                parts = (
                    np.frombuffer(_read(file, shape, dtype), dtype).reshape(shape)
                    for shape in shapes
                )
            for part in parts:
                yield part.astype(shard.DTYPES[like], copy=False)

    def _shape(self, field: str) -> tuple[int, ...]:
        with self._archive() as archive, archive.open(shard.file_name(field)) as file:
            shape, dtype, _ = _read_header(file)
        if dtype.kind not in "fbiu":
            raise UserError(f"{self.path} holds {field} of type {dtype}, not numbers")
        return shape

    @contextlib.contextmanager
    def _archive(self) -> Iterator[zipfile.ZipFile]:
        errors = zipfile.BadZipFile, zlib.error, EOFError, ValueError, RuntimeError
        with files.explaining_torn(self.path, *errors), zipfile.ZipFile(self.path) as archive:
            yield archive


def _read(file: IO[bytes], shape: tuple[int, ...], dtype: np.dtype) -> bytes:
    return file.read(int(np.prod(shape)) * dtype.itemsize)


def _read_header(file: IO[bytes]) -> tuple[tuple[int, ...], np.dtype, bool]:
    """Shape and type of the array in a `.npy` file, and whether its data are stored by column.

    Leaves the file at the data. Raises ValueError for an unknown format.
    """
    version = np.lib.format.read_magic(file)
    if version not in _READ_HEADER:
        raise ValueError(f"an array of format {version}")
    shape, fortran_order, dtype = _READ_HEADER[version](file)
    return shape, dtype, fortran_order and len(shape) > 1
