"""Shards of a data set simulated on a cluster, and sent back to be written here."""

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any

from pigbench import envs
from pigbench.cluster import Tasks
from pigbench.data import collect
from pigbench.data.collect import Episodes, Simulator, Source, Tell
from pigbench.data.manifest import Shard, Spec, spec_of
from pigbench.envs.oracles import POLICIES
from pigbench.settings import jax_defaults


def source(spec: Spec, tasks: Tasks) -> Source:
    """A source of shards for `collect.write_missing`: one task per shard."""
    content, rows = spec.as_json(), collect.most_rows(POLICIES[spec.policy], spec.rows_per_episode)

    def simulated(shards: Sequence[Shard], tell: Tell) -> Iterator[tuple[Shard, Episodes]]:
        by_name = {shard.name: shard for shard in shards}
        asked = {name: (content, shard) for name, shard in by_name.items()}
        for name, episodes in tasks.results(_simulate, asked):
            yield by_name[name], episodes
            tell(by_name[name], rows)

    return simulated


def _simulate(content: str, shard: Shard) -> Episodes:
    """Simulate a shard on the cluster."""
    with jax_defaults():
        return _simulator(content)(shard, lambda steps: None)


@lru_cache(maxsize=1)  # a process compiles only for its first shard
def _simulator(content: str) -> Simulator:
    spec = spec_of(content)
    env = envs.make(spec.environment, engine=spec.engine, profile=spec.physics)
    policy: Any = POLICIES[spec.policy]
    return collect.simulator(env, policy(env.scene), spec)
