"""OGBench's files: `F.npz` for training and `F-val.npz` for validation, an array a field.

Their rows are those of our shards, one after the other: whole episodes, `terminals` true on the
last row. Data passes through shard by shard, so that the memory needed is that of one shard.
"""

import contextlib
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import IO

import numpy as np

from pigbench import envs
from pigbench.data import collect, shard
from pigbench.data.dataset import Dataset, Split, sizes
from pigbench.data.manifest import Spec
from pigbench.data.writer import Writer
from pigbench.envs import CubeEnv
from pigbench.errors import UserError
from pigbench.support import files
from pigbench.support.progress import Progress

SUFFIX = ".npz"
_ENDINGS = {"train": "", "val": "-val"}  # of a split's file name, before the suffix
_REQUIRED = ("observations", "actions", "terminals")
_EPISODES_PER_SHARD = 50
_READ_HEADER = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}


def split_paths(path: Path) -> dict[str, Path]:
    """The file of each split, given that of training. Raises UserError unless it ends in .npz."""
    if path.suffix != SUFFIX:
        raise UserError(f"{path} does not end in {SUFFIX}, as OGBench's files do")
    return {split: path.with_stem(path.stem + ending) for split, ending in _ENDINGS.items()}


def write(dataset: Dataset, path: Path) -> None:
    """Writes the data set as OGBench's pair of files, each whole or not at all.

    Raises UserError when a split is empty: OGBench's loaders read both.
    """
    paths = split_paths(path)
    if not path.parent.is_dir():
        raise UserError(f"{path.parent} is no folder")
    splits = {name: dataset.split(name) for name in paths}
    total = sum(len(split.records) * len(split.spec.fields) for split in splits.values())
    with Progress("export", total=total, unit="files") as progress:
        for name, split in splits.items():
            _write_file(paths[name], split, progress)


def read(path: Path, *, environment: str, physics: str, folder: Path) -> None:
    """Makes a data set in `folder` of OGBench's pair of files, or continues one that was cut off.

    Numbers become float32, as OGBench's own loader has them. `physics` is the profile in which
    policies trained on the data are evaluated. Raises UserError when a file is missing or torn, or
    when its arrays are not those of the environment.
    """
    env = envs.make(environment, profile=physics)
    with contextlib.ExitStack() as stack:
        sources = {
            split: stack.enter_context(_Source(file)) for split, file in split_paths(path).items()
        }
        for source in sources.values():
            source.check(env)
        spec = _spec(env, path.stem, sources)
        _fill(Writer(folder, spec), spec, sources)


def _write_file(path: Path, split: Split, progress: Progress) -> None:
    with files.replacing_file(path) as file, zipfile.ZipFile(file, "w") as archive:
        for field in split.spec.fields:
            arrays = split.shards(field)
            header = np.lib.format.header_data_from_array_1_0(arrays[0])
            header["shape"] = (split.rows, *arrays[0].shape[1:])
            with archive.open(shard.file_name(field), "w", force_zip64=True) as member:
                np.lib.format.write_array_header_1_0(member, header)
                for array in arrays:
                    member.write(np.ascontiguousarray(array).data)
                    progress.advance(1, path.name)


def _spec(env: CubeEnv, name: str, sources: Mapping[str, "_Source"]) -> Spec:
    first, *others = sources.values()
    length = first.episode_length
    for source in others:
        if source.episode_length != length:
            raise UserError(
                f"{source.path} has episodes of {source.episode_length} rows, {first.path} of "
                f"{length}: all must be equally long"
            )
    return Spec(
        environment=env.spec.name,
        policy=name,
        physics=env.scene.profile,
        engine=env.backend,
        seed=0,
        episodes={split: source.rows // length for split, source in sources.items()},
        episodes_per_shard=_EPISODES_PER_SHARD,
        rows_per_episode=length,
        fields=tuple(f for f in first.fields if all(f in other.fields for other in others)),
        layout=sizes(env.layout),
        action_size=env.action_size,
        versions={
            source.path.name: f"SHA-256 {files.sha256(source.path)}" for source in sources.values()
        },
    )


def _fill(writer: Writer, spec: Spec, sources: Mapping[str, "_Source"]) -> None:
    missing = writer.missing()
    total = sum(source.rows for source in sources.values())
    with Progress("import", total=total, unit="rows") as progress:
        for split, source in sources.items():
            parts = [part for part in spec.plan() if part.split == split]
            counts = [part.episodes * spec.rows_per_episode for part in parts]
            pieces = [source.pieces(field, counts) for field in spec.fields]
            for part, *arrays in zip(parts, *pieces, strict=True):
                if part in missing:
                    content = dict(zip(spec.fields, arrays, strict=True))
                    for field, array in content.items():
                        problem = shard.field_problem(spec, field, array, rows=len(array))
                        if problem is not None:
                            raise UserError(f"{source.path}: {part.name} of {field} {problem}")
                    writer.write(part, content)
                progress.advance(part.episodes * spec.rows_per_episode, part.name)


class _Source:
    """One of the files, opened for reading: a context manager. Raises UserError when it is torn."""

    def __init__(self, path: Path) -> None:
        self.path = path
        if not path.is_file():
            raise UserError(f"{path} does not exist")
        with self._explaining():
            self._archive = zipfile.ZipFile(path)
        stored = self._archive.namelist()
        self.fields = tuple(field for field in shard.DTYPES if shard.file_name(field) in stored)
        for field in _REQUIRED:
            if field not in self.fields:
                raise UserError(f"{path} has no {field}")
        self.rows = self._header("terminals")[0]
        self.episode_length = self._episode_length()

    def __enter__(self) -> "_Source":
        return self

    def __exit__(self, *_: object) -> None:
        self._archive.close()

    def check(self, env: CubeEnv) -> None:
        """Raises UserError unless all arrays have the environment's shapes."""
        row_shapes = collect.row_shapes(env)
        for field in self.fields:
            shape, expected = self._header(field), (self.rows, *row_shapes[field])
            if shape != expected:
                raise UserError(
                    f"{self.path} does not fit {env.spec.name}: {field} has shape {shape} instead "
                    f"of {expected}"
                )

    def pieces(self, field: str, counts: Iterable[int]) -> Iterator[np.ndarray]:
        """The array's rows in pieces of so many rows, in the type of our shards."""
        with self._explaining(), self._archive.open(shard.file_name(field)) as file:
            (_, *row_shape), dtype = _read_header(file)
            for rows in counts:
                shape = (rows, *row_shape)
                data = file.read(int(np.prod(shape)) * dtype.itemsize)
                array = np.frombuffer(data, dtype).reshape(shape)
                yield array.astype(shard.DTYPES[field], copy=False)

    def _header(self, field: str) -> tuple[int, ...]:
        with self._explaining(), self._archive.open(shard.file_name(field)) as file:
            shape, dtype = _read_header(file)
        if dtype.kind not in "fbiu":
            raise UserError(f"{self.path} holds {field} of type {dtype}, not numbers")
        return shape

    def _episode_length(self) -> int:
        terminals = next(self.pieces("terminals", [self.rows]))
        if not terminals.any():
            raise UserError(f"{self.path} has no whole episode: its terminals are nowhere true")
        length = int(terminals.argmax()) + 1
        wrong = terminals != (np.arange(1, self.rows + 1) % length == 0)
        if wrong.any() or self.rows % length:
            row = int(wrong.argmax()) if wrong.any() else self.rows - 1
            raise UserError(
                f"{self.path} has episodes of unequal lengths: the first ends after {length} rows, "
                f"but terminals say otherwise in row {row}"
            )
        return length

    @contextlib.contextmanager
    def _explaining(self) -> Iterator[None]:
        try:
            yield
        except (zipfile.BadZipFile, zlib.error, EOFError, ValueError, RuntimeError) as error:
            raise UserError(f"{self.path} is torn: {error}") from None


def _read_header(file: IO[bytes]) -> tuple[tuple[int, ...], np.dtype]:
    """Shape and type of the array in a `.npy` file, whose data follows. Raises ValueError."""
    version = np.lib.format.read_magic(file)
    if version not in _READ_HEADER:
        raise ValueError(f"an array of format {version}")
    shape, fortran_order, dtype = _READ_HEADER[version](file)
    if fortran_order and len(shape) > 1:
        raise ValueError("an array is stored column by column")
    return shape, dtype
