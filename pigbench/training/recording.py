"""Evaluation episodes as they went, state by state."""

from functools import partial
from typing import NamedTuple

import jax
import numpy as np

from pigbench.agents import Agent, Params
from pigbench.envs import CubeEnv, State
from pigbench.envs.physics import PhysicsState
from pigbench.training import evaluate
from pigbench.training.evaluate import Evaluation, Report, Rollout

_CHUNK = 50  # control steps between two reports


class Recording(NamedTuple):
    """One episode."""

    task: int  # counts from 1
    qpos: np.ndarray  # (control steps + 1, nq), from the first state to the last
    target: np.ndarray  # (num_cubes, 3) metres, where the cubes should go
    success: bool


def record(
    env: CubeEnv, agent: Agent, params: Params, evaluation: Evaluation, report: Report
) -> list[Recording]:
    """The very episodes that `make_evaluator` rolls out, task after task."""

    def step(rollout: Rollout, _: None) -> tuple[Rollout, jax.Array]:
        rollout = evaluate.step(env, agent, params, rollout)
        return rollout, _qpos(rollout.states)

    chunk = min(_CHUNK, env.episode_length)
    advance = jax.jit(partial(jax.lax.scan, step, length=chunk))
    rollout = jax.jit(partial(evaluate.begin, env, evaluation))()
    first = rollout.states
    chunks = [np.asarray(_qpos(first))[None]]
    while rollout.time < env.episode_length and not rollout.states.done.all():
        rollout, qpos = advance(rollout)
        chunks.append(np.asarray(qpos))
        report(min(int(rollout.time), env.episode_length))
    successes = np.asarray(rollout.states.info["success"])
    lengths = np.minimum(rollout.values["length"], env.episode_length)
    states = np.concatenate(chunks)
    return [
        Recording(
            task=int(first.info["task"][i]),
            qpos=states[: lengths[i] + 1, i],
            target=np.asarray(first.info["target"][i]),
            success=bool(successes[i]),
        )
        for i in range(len(lengths))
    ]


def _qpos(states: State) -> jax.Array:
    physics_states: PhysicsState = states.pipeline_state  # pyright: ignore[reportAssignmentType]
    return physics_states.qpos
