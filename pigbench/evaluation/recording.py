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
        begun = start(params)
        chunks = [np.asarray(_qpos(begun.states))[None]]

        def further(rollout: Rollout, steps: int) -> Rollout:
            rollout, qpos = advance(params, rollout, steps=steps)
            chunks.append(np.asarray(qpos))
            return rollout

        ended = rollouts.finish(begun, further, env.episode_length, report)
        recordings = _recordings(ended, np.concatenate(chunks))
        return rollouts.outcome_of(ended, env, evaluation), recordings

    return record


def _recordings(ended: Rollout, qpos: Float[np.ndarray, "time episode nq"]) -> list[Recording]:
    """The episodes of a rollout, cut where each has ended."""
    info = {name: np.asarray(ended.states.info[name]) for name in ("task", "target", "success")}
    lengths = np.asarray(ended.values["length"])
    return [
        Recording(
            task=int(info["task"][i]),
            qpos=qpos[: lengths[i] + 1, i],
            target=info["target"][i],
            success=bool(info["success"][i]),
        )
        for i in range(len(lengths))
    ]


def _qpos(states: "envs.State") -> Float[Array, "episode nq"]:
    physics_states: PhysicsState = states.pipeline_state  # pyright: ignore[reportAssignmentType]
    return physics_states.qpos
