"""Whether a hierarchy that is given a distant goal proposes subgoals at the cube.

The starts are states of the data at which no cube is held yet but one is held K steps later. Goals
are much farther ahead, drawn as in training. The error is the distance from the subgoal's pinch
point to the cube. (With the state K steps ahead as the goal, as in `subgoals`, the agent could
copy the answer from the goal.)
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from pigbench import seeds
from pigbench.agents import FlowHierarchy, Params
from pigbench.analysis.modes import contact_modes, pinch_points
from pigbench.data import sampler
from pigbench.data.dataset import Split
from pigbench.envs.contact import HOLDING
from pigbench.envs.units import metres
from pigbench.layout import Layout

RESTING = 0.01
"""Metres in x and y by which a cube may move within the K steps. It is then grasped about where it
is now, so that a slightly earlier or later subgoal is at the same place."""

_DRAWS = 200_000  # of transitions and goals; only those before grasps are kept


class Grasps(NamedTuple):
    """States before grasps, with their goals."""

    starts: Float[np.ndarray, "batch observation"]
    ahead: Float[np.ndarray, "batch observation"]  # K steps later, when a cube is held
    goals: Float[np.ndarray, "batch observation"]  # more than 2 K steps later
    cube: Float[np.ndarray, "batch 2"]  # metres, x and y of the held cube K steps later


def draw(split: Split, agent: FlowHierarchy, layout: Layout, *, samples: int, seed: int) -> Grasps:
    """Up to `samples` grasps, with goals drawn as for the agent's actor in training."""
    steps = agent.config.subgoal_steps
    rows = sampler.Rows.from_split(split)
    drawn = sampler.sample_indices(seeds.key(seed), rows.episode_ends, agent.sampling, _DRAWS)
    starts, goals = np.asarray(drawn.starts), np.asarray(drawn.actor_goals)
    ends = np.asarray(rows.episode_ends)
    observations = np.asarray(rows.observations)
    inside = (starts + 2 * steps < goals) & (goals <= ends[np.searchsorted(ends, starts)])
    starts, goals = starts[inside], goals[inside]
    modes = contact_modes(observations, layout)
    taken = (modes[starts] != HOLDING) & (modes[starts + steps] == HOLDING)
    starts, goals = starts[taken], goals[taken]
    cube, moved = _held_cube(observations[starts], observations[starts + steps], layout)
    kept = np.flatnonzero(moved < RESTING)[:samples]
    starts = starts[kept]
    return Grasps(
        observations[starts], observations[starts + steps], observations[goals[kept]], cube[kept]
    )


def measure(
    agent: FlowHierarchy, params: Params, grasps: Grasps, *, seed: int
) -> dict[str, Float[np.ndarray, "batch"]]:
    """Metres in x and y from the subgoal's pinch point to the cube.

    Measured for the data's subgoal and for one drawn from the agent.
    """
    keys = jax.random.split(seeds.key(seed), len(grasps.starts))
    draw_subgoals = jax.jit(jax.vmap(agent.subgoal, (None, 0, 0, 0)))
    subgoals = {
        "the data's subgoal": agent.represent(jnp.asarray(grasps.ahead)),
        "generated": draw_subgoals(params, grasps.starts, grasps.goals, keys),
    }
    return {
        name: np.linalg.norm(pinch(agent, x)[:, :2] - grasps.cube, axis=-1)
        for name, x in subgoals.items()
    }


def pinch(agent: FlowHierarchy, subgoals: Float[Array, "batch x"]) -> Float[np.ndarray, "batch 3"]:
    """The pinch points of subgoals in metres."""
    return pinch_points(np.asarray(agent.represent.restore(subgoals)), agent.represent.layout)


def _held_cube(
    starts: Float[np.ndarray, "batch observation"],
    ahead: Float[np.ndarray, "batch observation"],
    layout: Layout,
) -> tuple[Float[np.ndarray, "batch 2"], Float[np.ndarray, "batch"]]:
    """Position in `ahead` of the cube nearest to the pinch point, and how far it moved.

    Both in metres, in x and y; the motion is from the cube's position in `starts`.
    """
    places = layout.group("object_positions").values()
    before, after = (
        metres(np.stack([states[:, part] for part in places])) for states in (starts, ahead)
    )
    apart = np.linalg.norm(after - pinch_points(ahead, layout), axis=-1)
    held = apart.argmin(axis=0), np.arange(len(ahead))
    cube = after[held][:, :2]
    return cube, np.linalg.norm(cube - before[held][:, :2], axis=-1)
