"""OGBench's files: `F.npz` for training and `F-val.npz` for validation, one array per field.

Their rows are those of our shards, one after another: whole episodes, with `terminals` true on the
last row. Files of what OGBench's loaders return are read too: with `valids`, false on an episode's
last row, or with `next_observations`, where a row is a transition. Data are processed file by file,
large files in pieces.

For `-oraclerep` environments, OGBench's loader computes goals, `oracle_reps`, from qpos. An export
may include them ready-made, for readers without that loader.
"""

import contextlib
import dataclasses
import itertools
import zipfile
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO

import jax.numpy as jnp
import numpy as np
from jaxtyping import Int

from pigbench import envs
from pigbench.agents.representations import GOALS, Representation
from pigbench.data import collect, shard
from pigbench.data.dataset import Dataset, Split
from pigbench.data.manifest import Shard, ShardRecord, Spec
from pigbench.data.shard import FieldArray
from pigbench.data.writer import Writer
from pigbench.errors import UserError, lookup
from pigbench.support import files
from pigbench.support.grouping import repeated
from pigbench.support.lock import only_writer
from pigbench.support.progress import Progress

SUFFIX = ".npz"
_ENDINGS = {"train": "", "val": "-val"}  # of a split's file name, before the suffix
_MOST_EPISODES = 1000  # per shard, and thus per piece: as many as in OGBench's files
_NEXT, _VALIDS, _ORACLE_REPS = "next_observations", "valids", "oracle_reps"
_READ_HEADER = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}

Columns = Mapping[str, tuple[str, Callable[[FieldArray], FieldArray]]]
"""For each array in a file: the field from which it is made, and the function that makes it."""


def split_paths(path: Path) -> dict[str, Path]:
    """The file of each split, given the training file. Raises UserError unless it ends in .npz."""
    if path.suffix != SUFFIX:
        raise UserError(f"{path} does not end in {SUFFIX}, as OGBench's files do")
    return {split: path.with_stem(path.stem + ending) for split, ending in _ENDINGS.items()}


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
        for name in _ENDINGS
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


def read(paths: Sequence[Path], *, environment: str, physics: str, folder: Path) -> None:
    """Make a data set in `folder` from OGBench's files, or continue one that was interrupted.

    `paths` are training files, or folders of them; the validation files beside them are read too.
    Numbers become float32, as in OGBench's own loader. `physics` is the profile in which policies
    trained on the data are evaluated. Raises UserError if a file is missing or torn, or if its
    arrays do not fit the environment.
    """
    files.require_folder(folder)
    env = envs.make(environment, profile=physics)
    found = _files(paths)
    total = sum(map(len, found.values()))
    with Progress("opening", total=total, unit="files") as progress:
        sources = {split: [_open(env, file, progress) for file in found[split]] for split in found}
    spec = _spec(env, sources)
    rows = sum(source.rows for own in sources.values() for source in own)
    with only_writer(folder):
        writer = Writer(folder, spec)
        share = sum(part.episodes for part in writer.missing()) / sum(spec.episodes.values())
        collect.require_room(env, spec.fields, round(share * rows), folder)
        _fill(writer, spec, sources)


def _files(paths: Sequence[Path]) -> dict[str, list[Path]]:
    """The files of each split: the named training files, and the validation files beside them."""
    named = [
        file
        for path in paths
        for file in (sorted(path.glob(f"*{SUFFIX}")) if path.is_dir() else [path])
    ]
    train = [file for file in named if not file.stem.endswith(_ENDINGS["val"])]
    if not train:
        raise UserError(f"{', '.join(map(str, paths))} holds no {SUFFIX} file of training")
    pairs = [split_paths(file) for file in train]
    twice = repeated(file.name for file in train)
    if twice is not None:
        raise UserError(f"two files are named {twice}: rename one")
    val = [pair["val"] for pair in pairs if pair["val"].is_file()]
    return {"train": train, "val": val or [pairs[0]["val"]]}


def _open(env: "envs.CubeEnv", file: Path, progress: Progress) -> "_Source":
    source = _Source(file, env)
    progress.advance(1, file.name)
    return source


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
        _ORACLE_REPS: ("observations", lambda rows: np.asarray(represent(jnp.asarray(rows)))),
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


def _spec(env: "envs.CubeEnv", sources: Mapping[str, Sequence["_Source"]]) -> Spec:
    every = list(itertools.chain(*sources.values()))
    lengths = np.unique(np.concatenate([source.lengths for source in every]))
    return Spec(
        environment=env.spec.name,
        policy=every[0].path.stem,
        physics=env.scene.profile,
        engine=env.backend,
        seed=0,
        episodes={
            split: sum(len(source.lengths) for source in own) for split, own in sources.items()
        },
        episodes_per_shard={
            split: tuple(count for source in own for count in source.pieces())
            for split, own in sources.items()
        },
        rows_per_episode=int(lengths[0]) if len(lengths) == 1 else 0,
        fields=tuple(field for field in every[0].fields if all(field in s.fields for s in every)),
        layout=env.layout,
        action_size=env.action_size,
        versions={source.path.name: f"SHA-256 {source.sha256}" for source in every},
    )


def _fill(writer: Writer, spec: Spec, sources: Mapping[str, Sequence["_Source"]]) -> None:
    missing = set(writer.missing())
    total = sum(source.rows for own in sources.values() for source in own)
    with Progress("import", total=total, unit="rows") as progress:
        for split, own in sources.items():
            planned = (part for part in spec.plan() if part.split == split)
            for source in own:
                parts = list(itertools.islice(planned, len(source.pieces())))
                if missing.isdisjoint(parts):
                    progress.advance(source.rows, source.path.name)
                else:
                    _fill_from(source, parts, missing, writer, spec, progress)


def _fill_from(
    source: "_Source",
    parts: Sequence[Shard],
    missing: set[Shard],
    writer: Writer,
    spec: Spec,
    progress: Progress,
) -> None:
    for part, arrays in zip(parts, source.read(spec.fields), strict=True):
        rows = len(arrays["terminals"])
        if part in missing:
            for field, array in arrays.items():
                problem = shard.field_problem(spec, field, array, rows=rows)
                if problem is not None:
                    raise UserError(f"{source.path}: {part.name} of {field} {problem}")
            writer.write(part, arrays)
        progress.advance(rows, part.name)


class _Source:
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
        self._transitions = _NEXT in self._stored
        kept = ("observations", "actions") if self._transitions else tuple(shard.DTYPES)
        ending = _VALIDS if _VALIDS in self._stored else "terminals"
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
        ends = np.flatnonzero(ends == (ending != _VALIDS))
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
        starts = range(0, len(self.lengths), _MOST_EPISODES)
        return [min(_MOST_EPISODES, len(self.lengths) - start) for start in starts]

    def _check_shapes(self, env: "envs.CubeEnv") -> None:
        """Raise UserError unless all arrays have the environment's shapes. Reads headers only."""
        row_shapes = collect.row_shapes(env)
        row_shapes |= {_NEXT: row_shapes["observations"], _VALIDS: ()}
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
        names += [_NEXT] if self._transitions else []
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
        observations, after = content["observations"], content[_NEXT]
        same = (observations[1:] == after[:-1]).all(axis=1)
        same[ends[:-1]] = True
        if not same.all():
            raise UserError(
                f"{self.path}: {_NEXT} are not the observations of the next row (first in row "
                f"{same.argmin()} of a piece)"
            )
        return {
            "observations": np.insert(observations, ends + 1, after[ends], axis=0),
            "actions": np.insert(content["actions"], ends + 1, 0, axis=0),
        }

    def _pieces(self, field: str, counts: Iterable[int]) -> Iterator[FieldArray]:
        """Yield the array in pieces of the given numbers of rows, in the type of our shards."""
        like = "observations" if field == _NEXT else "terminals" if field == _VALIDS else field
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
