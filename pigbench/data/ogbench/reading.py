"""Data sets made from OGBench's files."""

import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from pigbench import envs
from pigbench.data import collect, shard
from pigbench.data.dataset import ENDINGS
from pigbench.data.manifest import Shard, Spec
from pigbench.data.ogbench.names import SUFFIX, split_paths
from pigbench.data.ogbench.source import Source
from pigbench.data.writer import Writer
from pigbench.errors import UserError
from pigbench.support import files
from pigbench.support.grouping import repeated
from pigbench.support.lock import only_writer
from pigbench.support.progress import Progress


def read(paths: Sequence[Path], *, environment: str, physics: str, folder: Path) -> None:
    """Make a data set in `folder` from OGBench's files, or continue one that was interrupted.

    `paths` are files, or folders of them; validation files beside those of training are read too.
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
    """The named files of each split, and the validation files beside those of training."""
    named = [
        file
        for path in paths
        for file in (sorted(path.glob(f"*{SUFFIX}")) if path.is_dir() else [path])
    ]
    train = [file for file in named if not file.stem.endswith(ENDINGS["val"])]
    if not train:
        raise UserError(f"{', '.join(map(str, paths))} holds no {SUFFIX} file of training")
    pairs = [split_paths(file) for file in train]
    beside = [pair["val"] for pair in pairs if pair["val"].is_file()]
    val = list(dict.fromkeys([*beside, *(file for file in named if file not in train)]))
    twice = repeated(file.name for file in [*train, *val])
    if twice is not None:
        raise UserError(f"two files are named {twice}: rename one")
    return {"train": train, "val": val or [pairs[0]["val"]]}


def _open(env: "envs.CubeEnv", file: Path, progress: Progress) -> Source:
    source = Source(file, env)
    progress.advance(1, file.name)
    return source


def _spec(env: "envs.CubeEnv", sources: Mapping[str, Sequence[Source]]) -> Spec:
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
        versions={},
        origin={source.path.name: f"SHA-256 {source.sha256}" for source in every},
    )


def _fill(writer: Writer, spec: Spec, sources: Mapping[str, Sequence[Source]]) -> None:
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
    source: Source,
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
