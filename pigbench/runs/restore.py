"""Restoring a run's parts: environment, agent and trained parameters."""

import dataclasses
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import jax

from pigbench import agents, envs, seeds
from pigbench.agents import Agent, AgentConfig, TrainState
from pigbench.envs.reality import Reality
from pigbench.errors import UserError
from pigbench.evaluation import episodes
from pigbench.runs.checkpoints import Checkpoints
from pigbench.runs.run import CONFIG_FILE, Run, read_run
from pigbench.runs.statistics import read_statistics
from pigbench.support import schema

_LONGEST_STEP = 18  # digits


class Trained(NamedTuple):
    """A run with one of its checkpoints."""

    run: Run
    env: "envs.CubeEnv"
    agent: Agent
    state: TrainState


def restore(folder: Path, *, engine: str | None = None, checkpoint: str = "last") -> Trained:
    """The run in `folder`, with its last checkpoint, its best, or that of a step.

    The physics engine is that of the run's own evaluations unless `engine` names another. Raises
    UserError if there is no such run, or if it has no such checkpoint that is intact.
    """
    run = read_run(folder)
    env = envs.make(
        run.config.environment, engine=engine or run.config.engine, profile=run.config.physics
    )
    statistics = read_statistics(run.statistics_path)
    agent = agents.build(run.config.method, agent_config(run), env.space, statistics=statistics)
    with Checkpoints(run.checkpoints_path, read_only=True) as checkpoints:
        step = _step(run, sorted(checkpoints.steps()), checkpoint)
        like = jax.eval_shape(partial(agents.create, agent), seeds.key(0))
        state = checkpoints.restore(like, step)
    return Trained(run, env, agent, state)


def noisy(trained: Trained, deviation: float) -> "envs.CubeEnv":
    """The run's environment, its cubes' estimated positions with noise of another deviation.

    It is the standard deviation of every coordinate, in metres.
    """
    config, reality = trained.run.config, trained.env.reality or Reality()
    estimate = dataclasses.replace(reality.estimate, position_noise=deviation)
    return envs.make(
        config.environment,
        engine=trained.env.backend,
        profile=config.physics,
        reality=dataclasses.replace(reality, estimate=estimate),
    )


def agent_config(run: Run) -> AgentConfig:
    """The run's agent configuration. Raises UserError if it does not fit the method."""
    template = agents.get(run.config.method).config
    what = f"{run.path / CONFIG_FILE} holds no configuration of {run.config.method!r}"
    return schema.fill(template, run.config.agent, what)


def _step(run: Run, kept: Sequence[int], checkpoint: str) -> int:
    """The step of the requested checkpoint, among those that are kept."""
    if not kept:
        raise UserError(f"{run.path} has no checkpoint yet; train it first")
    if checkpoint == "last":
        return kept[-1]
    if checkpoint == "best":
        step = episodes.best_step(episodes.read(run.episodes_path))
    elif checkpoint.isdecimal() and len(checkpoint) <= _LONGEST_STEP:
        step = int(checkpoint)
    else:
        raise UserError(f"checkpoint is {checkpoint!r}: it must be last, best or a training step")
    if step not in kept:
        there = ", ".join(f"{one:,}" for one in kept)
        raise UserError(
            f"{run.path} has no checkpoint of step {step:,}, only of {there}: "
            "--keep best and --keep all of `pigbench train` keep more"
        )
    return step
