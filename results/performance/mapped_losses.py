"""Gradients of losses of a batch, beside those of one example that are mapped and averaged.

python mapped_losses.py METHOD...
"""

import sys
import time

import jax
import numpy as np

from pigbench import agents, envs, seeds
from pigbench.agents import Statistics
from pigbench.bench import training
from pigbench.data import sampler

TURNS, CALLS = 9, 20

env = envs.make("cube-single")
rows = training.noise(env)
for name in sys.argv[1:]:
    config = agents.get(name).preset("cpu", goals="cubes")
    statistics = Statistics.standard(env.observation_size)
    agent = agents.build(name, config, env.space, statistics=statistics)
    state = agents.create(agent, seeds.key(0))
    batch = sampler.sample(seeds.key(1), rows, agent.sampling, config.batch_size)

    def mapped(params, targets, batch, key, agent=agent):
        """The mean over the batch of the loss of one example."""

        def of_one(example):
            return agent.loss(params, targets, jax.tree.map(lambda x: x[None], example), key)

        losses, metrics = jax.vmap(of_one)(batch)
        return losses.mean(), jax.tree.map(lambda x: x.mean(), metrics)

    contenders = [jax.jit(jax.grad(loss, has_aux=True)) for loss in (agent.loss, mapped)]
    inputs = state.params, state.target_params, batch, seeds.key(2)
    gradients = [jax.tree.leaves(gradient(*inputs)[0]) for gradient in contenders]
    same = all(map(np.array_equal, *gradients))
    seconds = np.zeros((TURNS, 2))
    for turn, one in np.ndindex(seconds.shape):
        begun = time.process_time()
        for _ in range(CALLS):
            result = contenders[one](*inputs)
        jax.block_until_ready(result)
        seconds[turn, one] = time.process_time() - begun
    ratio = np.median(seconds[:, 1] / seconds[:, 0])
    print(f"{name}: {ratio:.2f} times as long, same bits: {same}", flush=True)
