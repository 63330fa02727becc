"""OGBench driven as its users drive it: one environment in one process, one episode at a time."""

import importlib
import itertools
from collections.abc import Iterator
from typing import Any

import jax
import numpy as np

from pigbench import agents
from pigbench.bench.timing import Contender
from pigbench.envs import CubeEnv
from pigbench.errors import UserError
from pigbench.training.restore import agent_for

NAME = "ogbench"
_PLANS = "ogbench.manipspace.oracles.plan.cube_plan"
_NOISE, _NOISE_SMOOTHING = 0.1, 0.5  # of the plans in its play data
_EPISODE_LENGTH = 1001


def generation(environment: str, *, stacking: float) -> Contender:
    """Play data, the choice of actions included: an item is a control step.

    `stacking` is how probably a target lies on another cube.
    """
    env = _make(environment, mode="data_collection")
    oracle = _import(_PLANS).CubePlanOracle(env=env, noise=_NOISE, noise_smoothing=_NOISE_SMOOTHING)

    def control_steps() -> Iterator[None]:
        for episode in itertools.count():
            observation, info = env.reset(seed=episode)
            oracle.reset(observation, info)
            for _ in range(_EPISODE_LENGTH):
                observation, _, _, _, info = env.step(oracle.select_action(observation, info))
                if oracle.done:
                    observation, info = env.set_new_target(p_stack=stacking)
                    oracle.reset(observation, info)
                yield

    return _contender(control_steps())


def evaluation(ours: CubeEnv, method: str, preset: str) -> Contender:
    """Evaluation episodes of a method's fresh policy: an item is a control step."""
    env = _make(ours.spec.name, mode="task")
    agent = agent_for(ours, method, agents.get(method).preset(preset))
    params = agents.create(agent, jax.random.key(0)).params
    act = jax.jit(agent.act)

    def control_steps() -> Iterator[None]:
        for episode in itertools.count():
            task = 1 + episode % ours.num_tasks
            observation, info = env.reset(seed=episode, options={"task_id": task})
            goal = np.asarray(info["goal"], np.float32)[None]
            for key in jax.random.split(jax.random.key(episode), ours.episode_length):
                states = np.asarray(observation, np.float32)[None]
                actions = act(params, states, goal, key)
                observation, *_ = env.step(np.asarray(actions[0]))
                yield

    return _contender(control_steps())


def _contender(control_steps: Iterator[None]) -> Contender:
    return Contender(NAME, lambda count: sum(1 for _ in itertools.islice(control_steps, count)))


def _make(environment: str, *, mode: str) -> Any:
    _import("ogbench")  # registers its environments
    gymnasium = _import("gymnasium")
    return gymnasium.make(f"{environment}-v0", mode=mode, terminate_at_goal=False).unwrapped


def _import(module: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError:
        raise UserError("the ogbench package is not installed: pip install ogbench") from None
