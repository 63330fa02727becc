"""A robot's logs as a data set: one episode per file (CSV, Parquet), or a LeRobot v3 folder.

`columns` describes a table's contents, `episode` turns them into rows.
"""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from pigbench import envs
from pigbench.data import collect
from pigbench.data.logs import lerobot, tables
from pigbench.data.logs.columns import LogTable
from pigbench.data.logs.episode import LoggedEpisode, observe, prepare
from pigbench.data.manifest import Spec
from pigbench.data.shard import IMPORTED_EPISODES, FieldArray
from pigbench.data.writer import Writer
from pigbench.errors import UserError
from pigbench.support import files
from pigbench.support.grouping import repeated
from pigbench.support.lock import only_writer
from pigbench.support.progress import Progress

REPORT = "import.json"
"""The file beside the manifest that lists gaps and outliers."""

_EVERY = 10  # one in so many episodes is for validation
POLICY = "log"


def read(paths: Sequence[Path], *, environment: str, physics: str, folder: Path) -> None:
    """Make a data set in `folder` from logs, or continue one that was interrupted.

    `paths` are files, folders of files, or LeRobot folders. Every tenth episode is for validation.
    `physics` is the profile in which policies trained on the data are evaluated. Raises UserError
    for the first log that is invalid.
    """
    files.require_folder(folder)
    env = envs.make(environment, profile=physics)
    if env.spec.num_cubes != 1:
        raise UserError(f"{environment} has {env.spec.num_cubes} cubes: a log tells of one object")
    sources = _sources(paths)
    episodes = []
    with Progress("reading", total=len(sources), unit="files") as progress:
        for path in sources:
            episodes += [prepare(name, table) for name, table in _tables(path)]
            progress.advance(1, path.name)
    splits = _splits(episodes)
    spec = _spec(env, sources, {split: len(own) for split, own in splits.items()})
    with only_writer(folder):
        writer = Writer(folder, spec)
        left = {split: iter(own) for split, own in splits.items()}
        todo = set(writer.missing())
        for part in spec.plan():
            own = list(itertools.islice(left[part.split], part.episodes))
            if part in todo:
                writer.write(part, _rows(env, own))
        files.write_json(folder / REPORT, {one.name: one.notes for one in episodes if one.notes})
    for one in episodes:
        for note in one.notes:
            print(f"{one.name}: {note}")


def _sources(paths: Sequence[Path]) -> list[Path]:
    """The files and LeRobot folders that `paths` name."""
    found = [
        source
        for path in paths
        for source in (
            [path]
            if not path.is_dir() or lerobot.is_dataset(path)
            else sorted(file for file in path.iterdir() if file.suffix in tables.READERS)
        )
    ]
    if not found:
        raise UserError(f"{', '.join(map(str, paths))} holds no log: no .csv, no .parquet")
    twice = repeated(source.name for source in found)
    if twice is not None:
        raise UserError(f"two logs are named {twice}: rename one")
    return found


def _tables(path: Path) -> Iterator[tuple[str, LogTable]]:
    if path.is_dir():
        return lerobot.read(path)
    return iter([(str(path), tables.read(path))])


def _spec(env: "envs.CubeEnv", sources: Sequence[Path], episodes: Mapping[str, int]) -> Spec:
    return Spec(
        environment=env.spec.name,
        policy=POLICY,
        physics=env.scene.profile,
        engine=env.backend,
        seed=0,
        episodes=dict(episodes),
        episodes_per_shard=IMPORTED_EPISODES,
        rows_per_episode=0,
        fields=collect.COMPACT,
        layout=env.layout,
        action_size=env.action_size,
        versions={},
        origin={
            str(file.relative_to(path.parent)): f"SHA-256 {files.sha256(file)}"
            for path in sources
            for file in (lerobot.files_of(path) if path.is_dir() else [path])
        },
    )


def _splits(episodes: Sequence[LoggedEpisode]) -> dict[str, list[LoggedEpisode]]:
    train = [one for place, one in enumerate(episodes) if place % _EVERY != _EVERY - 1]
    return {"train": train, "val": list(episodes[_EVERY - 1 :: _EVERY])}


def _rows(env: "envs.CubeEnv", episodes: list[LoggedEpisode]) -> dict[str, FieldArray]:
    lengths = [len(one.actions) for one in episodes]
    ends = np.cumsum(lengths) - 1
    return {
        "observations": observe(env, episodes),
        "actions": np.concatenate([one.actions for one in episodes]).astype(np.float32),
        "terminals": np.isin(np.arange(sum(lengths)), ends),
    }
