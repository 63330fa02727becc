"""Evaluating a policy: every task and episode in one vectorised rollout."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from pigbench.agents import Agent, Params
from pigbench.envs import CubeEnv, State
from pigbench.errors import UserError
from pigbench.training.episodes import Episode


@dataclass(frozen=True)
class Evaluation:
    """How a policy is evaluated: `episodes` episodes of every task, from their own seed."""

    episodes: int = 10
    seed: int = 0

    def __post_init__(self) -> None:
        if self.episodes < 1:
            raise UserError(f"episodes is {self.episodes}: it must be at least 1")


class Outcome(NamedTuple):
    """How episodes ended, arrays (tasks, episodes): diverged simulations have failed."""

    success: np.ndarray
    length: np.ndarray  # control steps
    diverged: np.ndarray


Evaluator = Callable[[Params], Outcome]


def make_evaluator(env: CubeEnv, agent: Agent, evaluation: Evaluation) -> Evaluator:
    """A function from the agent's parameters to the outcome of its episodes.

    An episode's scene and the policy's draws follow from the evaluation's seed, the task and the
    episode's number alone. The rollout stops when every episode has ended.
    """
    grid = np.indices((env.num_tasks, evaluation.episodes)).reshape(2, -1)

    def key(task: jax.Array, episode: jax.Array) -> jax.Array:
        task_key = jax.random.fold_in(jax.random.key(evaluation.seed), task)
        return jax.random.fold_in(task_key, episode)

    @jax.jit
    def rollout(params: Params) -> tuple[State, jax.Array]:
        tasks, episodes = jnp.asarray(grid[0] + 1, jnp.int32), jnp.asarray(grid[1], jnp.int32)
        reset_keys, act_keys = jax.vmap(lambda t, e: jax.random.split(key(t, e)), out_axes=1)(
            tasks, episodes
        )

        def going_on(carry: tuple[State, jax.Array, jax.Array]) -> jax.Array:
            states, _, time = carry
            return jnp.any(states.done == 0) & (time < env.episode_length)

        def step(
            carry: tuple[State, jax.Array, jax.Array],
        ) -> tuple[State, jax.Array, jax.Array]:
            states, lengths, time = carry
            keys = jax.vmap(jax.random.fold_in, in_axes=(0, None))(act_keys, time)
            lengths = lengths + (states.done == 0)
            actions = jax.vmap(lambda o, g, k: agent.act(params, o[None], g[None], k)[0])(
                states.obs, states.info["goal"], keys
            )
            return jax.vmap(env.step)(states, actions), lengths, time + 1

        states = jax.vmap(env.reset_task)(reset_keys, tasks)
        zero = jnp.zeros((), jnp.int32)
        states, lengths, _ = jax.lax.while_loop(
            going_on, step, (states, jnp.zeros_like(tasks), zero)
        )
        return states, lengths

    def evaluate(params: Params) -> Outcome:
        states, lengths = rollout(params)
        shape = (env.num_tasks, evaluation.episodes)
        arrays = (states.info["success"], lengths, states.info["diverged"])
        return Outcome(*(np.asarray(array).reshape(shape) for array in arrays))

    return evaluate


def as_episodes(
    outcome: Outcome, env: CubeEnv, evaluation: Evaluation, *, step: int
) -> list[Episode]:
    """The outcome as rows of `episodes.csv`, for the policy after `step` updates."""
    return [
        Episode(
            step=step,
            task=index + 1,
            task_name=task.name,
            episode=episode,
            seed=evaluation.seed,
            success=bool(outcome.success[index, episode]),
            length=int(outcome.length[index, episode]),
            diverged=bool(outcome.diverged[index, episode]),
        )
        for index, task in enumerate(env.spec.tasks)
        for episode in range(evaluation.episodes)
    ]
