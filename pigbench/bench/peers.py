"""OGBench, timed: one environment in one process, one episode at a time."""

import itertools
from collections.abc import Iterator
from functools import partial

import jax
import numpy as np

from pigbench import envs, seeds
from pigbench.bench.timing import Contender
from pigbench.bench.training import untrained
from pigbench.data.defaults import EPISODE_ROWS
from pigbench.fidelity import peer


def generation(environment: str) -> Contender:
    """Play data, including the choice of actions; an item is a control step."""
    env = peer.make(environment, mode="data_collection")
    episode = partial(peer.episode, env, "play", stacking=envs.SPECS[environment].stacking)
    return _contender(
        step
        for seed in itertools.count()
        for step in itertools.islice(episode(seed=seed), EPISODE_ROWS)
    )


def evaluation(ours: "envs.CubeEnv", method: str, preset: str) -> Contender:
    """Evaluation episodes of a method's untrained policy; an item is a control step."""
    env = peer.make(ours.spec.name, mode="task")
    agent, params = untrained(ours, method, preset)
    act = jax.jit(agent.act)

    def control_steps() -> Iterator[None]:
        for episode in itertools.count():
            task = 1 + episode % ours.num_tasks
            observation, info = env.reset(seed=episode, options={"task_id": task})
            goal = np.asarray(info["goal"], np.float32)
            for key in jax.random.split(seeds.key(episode), ours.episode_length):
                action = act(params, np.asarray(observation, np.float32), goal, key)
                observation, *_ = env.step(np.asarray(action))
                yield

    return _contender(control_steps())


def _contender(control_steps: Iterator[object]) -> Contender:
    return Contender(
        peer.NAME, lambda count: sum(1 for _ in itertools.islice(control_steps, count))
    )
