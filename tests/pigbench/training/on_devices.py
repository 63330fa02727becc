"""Trains on several devices and on one, and prints how far the parameters are apart.

Run as a script, with XLA_FLAGS that make four devices of a host.
"""

import json
from functools import cache

import jax
import numpy as np

from pigbench import agents
from pigbench.data.sampler import Rows
from pigbench.layout import Layout, Space
from pigbench.training.batches import Drawn
from pigbench.training.sharding import Sharding
from pigbench.training.updates import join, make_updates, split

STEPS, BATCH = 20, 64
CASES = ((4, False), (2, True))
"""Seeds, and whether their batches are split."""

CONFIG = agents.GCIVLConfig(actor_hidden_sizes=(32,), value_hidden_sizes=(32,), batch_size=BATCH)
AGENT = agents.build("gcivl", CONFIG, Space(Layout.of({"state": 4}), 2))


def rows() -> Rows:
    rng = np.random.default_rng(0)
    return Rows.create(
        rng.normal(size=(60, 4)).astype(np.float32),
        rng.uniform(-1, 1, size=(60, 2)).astype(np.float32),
        np.arange(60) % 20 == 19,
    )


@cache
def after(sharding: Sharding, seeds: int, steps: int = STEPS) -> list[np.ndarray]:
    """All numbers of the states of seeds 0, 1, ... after so many updates, in two calls."""
    keys = [jax.random.key(seed) for seed in range(seeds)]
    state = join([agents.create(AGENT, key) for key in keys])
    updates = make_updates(AGENT, join(keys), Drawn(rows(), AGENT), sharding)
    for start in range(0, steps, STEPS // 2):
        state, _ = updates(state, start, start + STEPS // 2)
    states = split(sharding.collect(state), seeds)
    assert all(len(leaf.devices()) == 1 for leaf in jax.tree.leaves(states))
    return [np.asarray(leaf) for leaf in jax.tree.leaves([state.params for state in states])]


def apart(some: list[np.ndarray], others: list[np.ndarray]) -> float:
    return max(float(np.abs(one - other).max()) for one, other in zip(some, others, strict=True))


def main() -> None:
    for seeds, data_parallel in CASES:
        sharding = Sharding.over_all(seeds=seeds, batch_size=BATCH, data_parallel=data_parallel)
        one = after(Sharding(), seeds)
        print(
            json.dumps(
                {
                    "devices": jax.device_count(),
                    "sharding": [sharding.seeds, sharding.batch],
                    "apart": apart(after(sharding, seeds), one),
                    "moved": apart(after(Sharding(), seeds, steps=0), one),
                }
            )
        )


if __name__ == "__main__":
    main()
