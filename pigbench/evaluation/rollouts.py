"""Evaluation of a policy: all tasks and episodes in one vectorised rollout."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, Key, Shaped

from pigbench import envs, seeds
from pigbench.agents import Agent, Params
from pigbench.envs.physics import warn_of_overflow
from pigbench.evaluation import folding
from pigbench.evaluation.episodes import Episode
from pigbench.evaluation.measures import MEASURES, Value
from pigbench.evaluation.settings import Evaluation
from pigbench.support import memory

_CHUNK = 50  # control steps between two reports

Outcome = Mapping[str, Shaped[np.ndarray, "task episode"]]  # by name in `MEASURES`
Report = Callable[[int], None]  # called with the control steps that the longest episode has taken
Evaluator = Callable[[Params, Report], Outcome]


class Rollout(NamedTuple):
    """Episodes in progress, task after task; `time` is the steps that the longest has taken."""

    states: "envs.State"
    act_keys: Key[Array, "episode"]
    start: Float[Array, "episode cube 3"]  # metres, the cubes' initial positions
    values: dict[str, Shaped[Array, "episode"]]  # of the measures so far
    time: Int[Array, ""]


def begin(env: "envs.CubeEnv", evaluation: Evaluation) -> Rollout:
    """All episodes at their start.

    An episode's scene and the policy's draws depend only on the evaluation's seed, the task and the
    episode's number. Raises UserError if so many do not fit into this machine's memory.
    """
    memory.require_for(env.num_tasks * evaluation.episodes)
    tasks, episodes = jnp.indices((env.num_tasks, evaluation.episodes)).reshape(2, -1)
    tasks += 1

    def keys(
        task: Int[Array, ""], episode: Int[Array, ""]
    ) -> tuple[Key[Array, ""], Key[Array, ""]]:
        task_key = jax.random.fold_in(seeds.key(evaluation.seed), task)
        reset_key, act_key = jax.random.split(jax.random.fold_in(task_key, episode))
        return reset_key, act_key

    reset_keys, act_keys = jax.vmap(keys)(tasks, episodes)
    states = jax.vmap(env.reset_task)(reset_keys, tasks)
    return Rollout(
        states,
        act_keys,
        start=jax.vmap(partial(folding.cubes, env))(states),
        values={name: jnp.full(len(tasks), value) for name, value in folding.begin().items()},
        time=jnp.zeros((), jnp.int32),
    )


def make_start(env: "envs.CubeEnv", evaluation: Evaluation) -> Callable[[Params], Rollout]:
    """A function that begins the rollout on the device of the parameters.

    Restored parameters are committed to a device, and so is a rollout that is advanced with them.
    If it did not begin there, a second program would be compiled to advance it further.
    """
    return jax.jit(lambda params: begin(env, evaluation), keep_unused=True)


def step(env: "envs.CubeEnv", agent: Agent, params: Params, rollout: Rollout) -> Rollout:
    """Do one control step in the episodes that are not done."""
    states = rollout.states
    act = jax.vmap(partial(action, agent, params), in_axes=(0, 0, 0, None))
    observations: Float[Array, "episode observation"] = states.obs  # pyright: ignore[reportAssignmentType]
    actions = act(observations, states.info["goal"], rollout.act_keys, rollout.time)
    after = jax.vmap(env.step)(states, actions)
    moments = jax.vmap(partial(folding.moment, env))(after, rollout.start)
    values = jax.vmap(folding.advance)(rollout.values, moments, states.done == 0)
    return rollout._replace(states=after, values=values, time=rollout.time + 1)


def action(
    agent: Agent,
    params: Params,
    observation: Float[Array, "observation"],
    goal: Float[Array, "observation"],
    key: Key[Array, ""],
    time: Int[Array, ""],
) -> Float[Array, "action"]:
    """The action in one episode after `time` steps; its draws depend on `key` and `time`."""
    return agent.act(params, observation, goal, jax.random.fold_in(key, time))


def make_evaluator(env: "envs.CubeEnv", agent: Agent, evaluation: Evaluation) -> Evaluator:
    """A function from the agent's parameters to the outcome of its episodes.

    The rollout stops when every episode has ended.
    """
    start = make_start(env, evaluation)

    @jax.jit
    def advance(params: Params, rollout: Rollout, stop: int) -> Rollout:
        def going_on(rollout: Rollout) -> Bool[Array, ""]:
            return jnp.any(rollout.states.done == 0) & (rollout.time < stop)

        return jax.lax.while_loop(going_on, partial(step, env, agent, params), rollout)

    def evaluate(params: Params, report: Report) -> Outcome:
        def further(rollout: Rollout, steps: int) -> Rollout:
            return advance(params, rollout, int(rollout.time) + steps)

        rollout = finish(start(params), further, env.episode_length, report)
        return outcome_of(rollout, env, evaluation)

    return evaluate


def finish(
    rollout: Rollout,
    further: Callable[[Rollout, int], Rollout],
    episode_length: int,
    report: Report,
) -> Rollout:
    """Advance the rollout until every episode has ended, with reports on the way.

    `further` advances it by so many control steps, or by fewer if the last episode ends.
    """
    while (time := int(rollout.time)) < episode_length and not np.all(rollout.states.done):
        # Not a step more than the limit: what an episode reaches after it does not count.
        rollout = further(rollout, min(_CHUNK, episode_length - time))
        report(int(rollout.time))
    return rollout


def outcome_of(rollout: Rollout, env: "envs.CubeEnv", evaluation: Evaluation) -> Outcome:
    """What came of a rollout that has ended. Warns if its physics ran out of memory."""
    warn_of_overflow(env.simulation(rollout.states))
    shape = (env.num_tasks, evaluation.episodes)
    return {name: np.asarray(rollout.values[name]).reshape(shape) for name in MEASURES}


def as_episodes(
    outcome: Outcome, env: "envs.CubeEnv", evaluation: Evaluation, *, step: int
) -> list[Episode]:
    """The outcome as rows of `episodes.csv`, for the policy after `step` updates."""
    return [
        Episode(
            step=step,
            task=index + 1,
            task_name=task.name,
            episode=episode,
            seed=evaluation.seed,
            engine=env.backend,
            measures=_known({name: array[index, episode] for name, array in outcome.items()}),
        )
        for index, task in enumerate(env.spec.tasks)
        for episode in range(evaluation.episodes)
    ]


def _known(values: Mapping[str, np.generic]) -> dict[str, Value]:
    """The values of an episode that are not NaN."""
    return {name: value.item() for name, value in values.items() if not np.isnan(value)}
