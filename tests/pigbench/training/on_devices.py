"""Trains on several devices and on one, and prints how far the parameters are apart.

Run as a script, with XLA_FLAGS that make four devices of a host, and the number of seeds.
"""

import json
import sys

import jax
import numpy as np

from pigbench import agents
from pigbench.data.sampler import Rows
from pigbench.training.batches import Drawn
from pigbench.training.layout import Layout
from pigbench.training.train import join, make_updates

STEPS = 20


def main(seeds: int, data_parallel: bool) -> None:
    rng = np.random.default_rng(0)
    rows = Rows.create(
        rng.normal(size=(60, 4)).astype(np.float32),
        rng.uniform(-1, 1, size=(60, 2)).astype(np.float32),
        np.arange(60) % 20 == 19,
    )
    small = {"actor_hidden_sizes": (32,), "value_hidden_sizes": (32,), "batch_size": 64}
    config = agents.GCIVLConfig(**small, regularizer=agents.Regularizer("hjb"))
    agent = agents.build("hjb-gcivl", config, observation_size=4, action_size=2, layout={})
    layout = Layout.over_all(seeds=seeds, batch_size=64, data_parallel=data_parallel)
    keys = [jax.random.key(seed) for seed in range(seeds)]
    key = join(keys)

    def after(layout: Layout) -> list[np.ndarray]:
        states = [agents.create(agent, key) for key in keys]
        updates = make_updates(agent, key, Drawn(rows, agent), layout)
        for start in (0, STEPS // 2):
            states, _ = updates(states, start, start + STEPS // 2)
        assert all(len(leaf.devices()) == 1 for leaf in jax.tree.leaves(states))
        return [np.asarray(leaf) for leaf in jax.tree.leaves(states)]

    begun = jax.tree.leaves([agents.create(agent, key) for key in keys])
    pairs = list(zip(after(layout), after(Layout()), strict=True))
    print(
        json.dumps(
            {
                "layout": [layout.seeds, layout.batch],
                "apart": max(float(np.abs(one - other).max()) for one, other in pairs),
                "moved": max(
                    float(np.abs(one - np.asarray(leaf)).max())
                    for (one, _), leaf in zip(pairs, begun, strict=True)
                    if one.dtype == np.float32
                ),
                "devices": jax.device_count(),
            }
        )
    )


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2] == "data-parallel")
