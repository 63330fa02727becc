"""Putting a run's parts together again: environment, agent and trained parameters."""

from pathlib import Path
from typing import NamedTuple

import jax

from pigbench import agents, envs
from pigbench.agents import Agent, AgentConfig, Statistics, TrainState
from pigbench.envs import CubeEnv
from pigbench.errors import UserError
from pigbench.training.checkpoints import Checkpoints, common_step
from pigbench.training.run import Run, agent_config, read_run, read_statistics


class Trained(NamedTuple):
    """A run with its last checkpoint."""

    run: Run
    env: CubeEnv
    agent: Agent
    state: TrainState


def agent_for(
    env: CubeEnv, method: str, config: AgentConfig, statistics: Statistics | None
) -> Agent:
    """The agent of a method for the environment's observations and actions.

    `statistics` are those of the observations that it learns from.
    """
    return agents.build(
        method,
        config,
        observation_size=env.observation_size,
        action_size=env.action_size,
        layout=env.layout,
        statistics=statistics,
    )


def restore(folder: Path, *, engine: str | None = None) -> Trained:
    """The run in `folder`. Raises UserError when there is none, or it has no whole checkpoint."""
    run = read_run(folder)
    env = envs.make(run.config.environment, engine=engine, profile=run.config.physics)
    agent = agent_for(env, run.config.method, agent_config(run), read_statistics(run))
    with Checkpoints(run.checkpoints_path, read_only=True) as checkpoints:
        step = common_step([checkpoints])
        if step is None:
            raise UserError(f"{folder} has no checkpoint yet; train it first")
        state = checkpoints.restore(agents.create(agent, jax.random.key(0)), step)
    return Trained(run, env, agent, state)
