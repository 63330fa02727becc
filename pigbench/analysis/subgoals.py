"""How near a hierarchy comes to states that the data reached as far ahead as subgoals are.

Simulations start from states of the data and are compared with the data's state K steps later.
Several ways of getting there separate the errors of the levels: no motion; the data's own actions;
the low level, whose subgoal at each step is the data's state K steps after it, as in training; the
low level, whose subgoal is always the state compared with; and both levels, with that state as the
goal.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, Key, Shaped

from pigbench import envs, seeds
from pigbench.agents import FlowHierarchy, Params
from pigbench.analysis.modes import contact_modes, pinch_points
from pigbench.data.dataset import Split
from pigbench.envs.units import POSITION_SCALE
from pigbench.errors import UserError
from pigbench.layout import Layout

Way = Callable[[Float[Array, "batch observation"], Int[Array, ""]], Float[Array, "batch action"]]
"""Maps observations and the number of steps done to actions."""

STILL, REPLAYED = "no motion", "the data's actions"
AHEAD, FIXED, BOTH = "low level, K ahead", "low level, fixed subgoal", "both levels"


class Distances(NamedTuple):
    """Distances in metres from the data's state; `cube` is that of the farthest cube."""

    pinch: Float[np.ndarray, "batch"]
    cube: Float[np.ndarray, "batch"]


class Stretches(NamedTuple):
    """Stretches of K steps from a data set, each followed by K steps of the same episode."""

    qpos: Float[np.ndarray, "batch nq"]  # at their starts
    qvel: Float[np.ndarray, "batch nv"]  # at their starts
    starts: Float[np.ndarray, "batch observation"]
    ahead: Float[np.ndarray, "time batch observation"]  # K steps later; the first: at their ends
    actions: Float[np.ndarray, "time batch action"]


def draw(split: Split, steps: int, *, samples: int, seed: int) -> Stretches:
    """Draw stretches of K = `steps` transitions, uniformly over all that exist.

    Raises UserError if no episode is long enough or the data set has no simulator states.
    """
    terminals = split.concatenate("terminals")
    last = np.flatnonzero(terminals)[np.cumsum(terminals) - terminals]  # row of each row's episode
    begins = np.flatnonzero(np.arange(len(terminals)) + 2 * steps <= last)
    if not len(begins):
        raise UserError(f"{split.folder} has no episode of {2 * steps} transitions, twice K")
    rows = np.asarray(jax.random.choice(seeds.key(seed), begins, (samples,)))
    stretches = rows + np.arange(steps)[:, None]
    observations = split.concatenate("observations")
    return Stretches(
        qpos=split.concatenate("qpos")[rows],
        qvel=split.concatenate("qvel")[rows],
        starts=observations[rows],
        ahead=observations[stretches + steps],
        actions=split.concatenate("actions")[stretches],
    )


def measure(
    env: "envs.CubeEnv", agent: FlowHierarchy, params: Params, stretches: Stretches, *, seed: int
) -> tuple[Shaped[np.ndarray, "batch"], Mapping[str, Distances]]:
    """Contact modes at the stretches' starts, and distances at their ends for each way.

    Simulates without the environment's `reality`, whose state data do not record.
    """
    starts, aims = stretches.starts, stretches.ahead[0]
    subgoals = agent.represent(jnp.asarray(stretches.ahead))
    actions = jnp.asarray(stretches.actions)

    def keys(time: Int[Array, ""]) -> Key[Array, "batch"]:
        return jax.random.split(jax.random.fold_in(seeds.key(seed), time), len(starts))

    act, follow = (jax.vmap(way, (None, 0, 0, 0)) for way in (agent.act, agent.follow))
    ways: dict[str, Way] = {
        REPLAYED: lambda states, time: actions[time],
        AHEAD: lambda states, time: follow(params, states, subgoals[time], keys(time)),
        FIXED: lambda states, time: follow(params, states, subgoals[0], keys(time)),
        BOTH: lambda states, time: act(params, states, aims, keys(time)),
    }
    ends = {STILL: starts} | {name: _simulate(env, way, stretches) for name, way in ways.items()}
    return contact_modes(starts, env.layout), {
        name: _distances(reached, aims, env.layout) for name, reached in ends.items()
    }


def _simulate(
    env: "envs.CubeEnv", way: Way, stretches: Stretches
) -> Float[np.ndarray, "batch observation"]:
    """Observations at the stretches' ends."""

    @jax.jit
    def run(
        qpos: Float[Array, "batch nq"], qvel: Float[Array, "batch nv"]
    ) -> Float[Array, "batch observation"]:
        def step(states, time):
            actions = way(jax.vmap(env.observe)(states), time)
            return jax.vmap(env.simulate)(states, actions), None

        states = jax.vmap(env.physics.init)(qpos, qvel)
        states, _ = jax.lax.scan(step, states, jnp.arange(len(stretches.actions)))
        return jax.vmap(env.observe)(states)

    return np.asarray(run(stretches.qpos, stretches.qvel))


def _distances(
    states: Float[np.ndarray, "batch observation"],
    aims: Float[np.ndarray, "batch observation"],
    layout: Layout,
) -> Distances:
    def apart(part: slice) -> Float[np.ndarray, "batch"]:
        return np.linalg.norm(states[:, part] - aims[:, part], axis=-1) / POSITION_SCALE

    cubes = [apart(part) for part in layout.group("object_positions").values()]
    pinch = pinch_points(states, layout) - pinch_points(aims, layout)
    return Distances(np.linalg.norm(pinch, axis=-1), np.max(cubes, axis=0))
