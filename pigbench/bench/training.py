"""Training, timed: the updates of methods on rows of noise."""

from collections.abc import Iterable, Mapping

import jax
import numpy as np

from pigbench import agents, envs
from pigbench.agents import Agent, AgentConfig, Params, Statistics
from pigbench.bench.timing import Contender, Timing
from pigbench.data.defaults import EPISODE_ROWS
from pigbench.data.sampler import Rows
from pigbench.seeds import key as seed_key
from pigbench.training.batches import Drawn
from pigbench.training.updates import join, make_updates

_EPISODES = 20


def contenders(environment: str, methods: Iterable[str], preset: str) -> list[Contender]:
    """Each method's updates at a preset, including the sampling of batches; a unit is an update."""
    env = envs.make(environment)
    rows = noise(env)
    return [updates(env, rows, method, agents.get(method).preset(preset)) for method in methods]


def table(timings: Mapping[str, Timing]) -> list[tuple[str, ...]]:
    """One line per method, compared with the first, and a header."""
    reference = next(iter(timings))
    lines = [
        (
            name,
            f"{1e3 * timing.median:.1f}",
            f"{timing.ratio(timings[reference]):.2f}",
            f"{timing.first - timing.median:.1f}",
        )
        for name, timing in timings.items()
    ]
    return [("method", "ms per update", f"times {reference}", "s to compile"), *lines]


def updates(
    env: "envs.CubeEnv",
    rows: Rows,
    method: str,
    config: AgentConfig,
    *,
    seeds: int = 1,
    name: str = "",
) -> Contender:
    """The updates of a method with the given hyperparameters, under its own or another name.

    Seeds are trained together; an item is one seed's update.
    """
    keys = [jax.random.split(seed_key(seed)) for seed in range(seeds)]
    agent = agents.build(method, config, env.space, statistics=_standard(env))
    key = join([step_key for _, step_key in keys])
    run = make_updates(agent, key, Drawn(rows, agent))
    state, done = join([agents.create(agent, init_key) for init_key, _ in keys]), 0

    def work(count: int) -> None:
        nonlocal state, done
        state, _ = jax.block_until_ready(run(state, done, done + count))
        done += count

    return Contender(name or method, work, items=seeds)


def untrained(env: "envs.CubeEnv", method: str, preset: str) -> tuple[Agent, Params]:
    """A method's agent at a preset, with initial parameters."""
    config = agents.get(method).preset(preset)
    agent = agents.build(method, config, env.space, statistics=_standard(env))
    return agent, agents.create(agent, seed_key(0)).params


def _standard(env: "envs.CubeEnv") -> Statistics:
    """Statistics of the observations of `noise`."""
    return Statistics.standard(env.observation_size)


def noise(env: "envs.CubeEnv") -> Rows:
    """Rows shaped like those of an environment's data set. Their values do not affect the time."""
    draws = np.random.default_rng(0)
    count = _EPISODES * EPISODE_ROWS
    return Rows.create(
        draws.standard_normal((count, env.observation_size), np.float32),
        draws.uniform(-1, 1, (count, env.action_size)).astype(np.float32),
        np.arange(1, count + 1) % EPISODE_ROWS == 0,
    )
