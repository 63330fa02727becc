"""A data set of any size to measure with: a few simulated episodes, repeated, then deleted."""

import dataclasses
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from pigbench import envs
from pigbench.data import collect
from pigbench.data.defaults import EPISODE_ROWS
from pigbench.data.manifest import Shard, Spec
from pigbench.data.writer import Writer
from pigbench.envs.oracles import POLICIES
from pigbench.provenance import package_versions
from pigbench.support.progress import Progress

_EPISODES_PER_SHARD, _SIMULATED = 50, 5  # a shard repeats the simulated episodes


@contextmanager
def dataset(environment: str, transitions: int, folder: Path | None) -> Iterator[Path]:
    """The folder of a temporary data set of so many transitions.

    It is made in `folder`, by default the system's folder of temporary files.
    """
    with tempfile.TemporaryDirectory(prefix="pigbench-rows-", dir=folder) as made:
        _write(environment, transitions, Path(made) / "data")
        yield Path(made) / "data"


def _write(environment: str, transitions: int, folder: Path) -> None:
    env = envs.make(environment)
    episodes = -(-transitions // (EPISODE_ROWS - 1))
    spec = Spec(
        environment=environment,
        policy="play",
        physics=env.scene.profile,
        engine=env.backend,
        seed=0,
        episodes={"train": episodes},
        episodes_per_shard=_SIMULATED,
        rows_per_episode=EPISODE_ROWS,
        fields=collect.COMPACT,
        layout=env.layout,
        action_size=env.action_size,
        versions=package_versions(),
    )
    collect.require_room(env, spec.fields, episodes * EPISODE_ROWS, folder)
    simulate = collect.simulator(env, POLICIES["play"](env.spec, env.scene), spec)
    with Progress("simulating", total=EPISODE_ROWS, unit="control steps") as progress:
        simulated = simulate(Shard("", "train", 0, _SIMULATED), progress.advance).arrays
    arrays = {
        field: np.concatenate([array] * (_EPISODES_PER_SHARD // _SIMULATED))
        for field, array in simulated.items()
    }
    spec = dataclasses.replace(spec, episodes_per_shard=_EPISODES_PER_SHARD)
    writer = Writer(folder, spec)
    missing = writer.missing()
    with Progress("writing", total=len(missing), unit="shards") as progress:
        for part in missing:
            rows = part.episodes * EPISODE_ROWS
            writer.write(part, {field: array[:rows] for field, array in arrays.items()})
            progress.advance(1)
