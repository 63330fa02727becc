"""Recordings of evaluation episodes, state by state."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Array, Float

from pigbench import envs
from pigbench.agents import Agent, Params
from pigbench.envs.physics import PhysicsState
from pigbench.evaluation import rollouts
from pigbench.evaluation.rollouts import Outcome, Report, Rollout
from pigbench.evaluation.settings import Evaluation

_CHUNK = 50  # control steps between two reports


class Recording(NamedTuple):
    """One recorded episode."""

    task: int  # counts from 1
    qpos: Float[np.ndarray, "time nq"]  # from the first state to the last
    target: Float[np.ndarray, "cube 3"]  # metres, the cubes' targets
    success: bool


Recorder = Callable[[Params, Report], tuple[Outcome, list[Recording]]]


def make_recorder(env: "envs.CubeEnv", agent: Agent, evaluation: Evaluation) -> Recorder:
    """Like `make_evaluator`; the function also returns the recorded episodes, task after task."""
    start = rollouts.make_start(env, evaluation)

    @partial(jax.jit, static_argnames="steps")
    def advance(
        params: Params, rollout: Rollout, *, steps: int
    ) -> tuple[Rollout, Float[Array, "{steps} episode nq"]]:
        def step(rollout: Rollout, _: None) -> tuple[Rollout, Float[Array, "episode nq"]]:
            rollout = rollouts.step(env, agent, params, rollout)
            return rollout, _qpos(rollout.states)

        return jax.lax.scan(step, rollout, length=steps)

    def record(params: Params, report: Report) -> tuple[Outcome, list[Recording]]:
        rollout, recordings = _record(start, advance, env.episode_length, params, report)
        return rollouts.outcome_of(rollout, env, evaluation), recordings

    return record


def _record(
    start: Callable[[Params], Rollout],
    advance: Callable[..., tuple[Rollout, Float[Array, "time episode nq"]]],
    episode_length: int,
    params: Params,
    report: Report,
) -> tuple[Rollout, list[Recording]]:
    rollout = start(params)
    first = rollout.states
    chunks = [np.asarray(_qpos(first))[None]]
    while rollout.time < episode_length and not rollout.states.done.all():
        # Not a step more than the limit: what an episode reaches after it does not count.
        steps = min(_CHUNK, episode_length - int(rollout.time))
        rollout, qpos = advance(params, rollout, steps=steps)
        chunks.append(np.asarray(qpos))
        report(int(rollout.time))
    successes = np.asarray(rollout.states.info["success"])
    lengths = np.asarray(rollout.values["length"])
    states = np.concatenate(chunks)
    return rollout, [
        Recording(
            task=int(first.info["task"][i]),
            qpos=states[: lengths[i] + 1, i],
            target=np.asarray(first.info["target"][i]),
            success=bool(successes[i]),
        )
        for i in range(len(lengths))
    ]


def _qpos(states: "envs.State") -> Float[Array, "episode nq"]:
    physics_states: PhysicsState = states.pipeline_state  # pyright: ignore[reportAssignmentType]
    return physics_states.qpos
