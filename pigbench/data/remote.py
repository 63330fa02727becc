"""Shards of a data set simulated on a cluster, and sent back to be written here."""

from collections.abc import Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from pigbench import envs, plugins
from pigbench.cluster import Tasks
from pigbench.data import collect
from pigbench.data.collect import Episodes, ShardSimulator, Source, Tell
from pigbench.data.manifest import Shard, Spec, spec_of
from pigbench.envs.oracles import POLICIES
from pigbench.settings import jax_defaults


def source(spec: Spec, tasks: Tasks) -> Source:
    """A source of shards for `collect.write_missing`: one task per shard."""
    rows = collect.most_rows(POLICIES[spec.policy], spec.rows_per_episode)
    content, files = spec.as_json(), tuple(plugins.loaded_files())

    def simulated(shards: Sequence[Shard], tell: Tell) -> Iterator[tuple[Shard, Episodes]]:
        by_name = {shard.name: shard for shard in shards}
        asked = {name: (content, files, shard) for name, shard in by_name.items()}
        for name, episodes in tasks.results(_simulate, asked):
            yield by_name[name], episodes
            tell(by_name[name], rows)

    return simulated


def _simulate(content: str, files: tuple[str, ...], shard: Shard) -> Episodes:
    """Simulate a shard on the cluster, with the plugins installed there and those in `files`."""
    with jax_defaults():
        return _simulator(content, files)(shard, lambda steps: None)


@lru_cache(maxsize=1)  # a process compiles only for its first shard
def _simulator(content: str, files: tuple[str, ...]) -> ShardSimulator:
    plugins.load_installed()
    for file in files:
        plugins.load_file(Path(file))
    spec = spec_of(content)
    env = envs.make(spec.environment, engine=spec.engine, profile=spec.physics)
    policy: Any = POLICIES[spec.policy]
    return collect.simulator(env, policy(env.spec, env.scene), spec)
