"""The computation of `MEASURES`, which say how far an evaluation episode got.

A measure is a small function of one simulation after a control step, folded over the episode.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from pigbench import envs
from pigbench.envs.contact import HOLDING_DISTANCE, TOUCHING_DISTANCE, feels
from pigbench.envs.observation import cube_poses
from pigbench.envs.physics import PhysicsState
from pigbench.training.measures import MEASURES, Value

LIFT = 0.02
"""Metres above its start at which a cube counts as lifted: one tipped over an edge rises by 0.8 cm,
over a corner by 1.5 cm."""

Values = dict[str, jax.Array]  # by measure


class Moment(NamedTuple):
    """One simulation after a control step, positions in metres."""

    start: jax.Array  # (num_cubes, 3) the cubes at the start of the episode
    cubes: jax.Array  # (num_cubes, 3)
    target: jax.Array  # (num_cubes, 3)
    pinch: jax.Array  # (3,)
    pad_force: jax.Array  # ()
    success: jax.Array  # () bool
    diverged: jax.Array  # () bool: if true, the rest is from the last good state


class Fold(NamedTuple):
    """How a measure's values after each step are combined into the episode's."""

    start: Value
    combine: Callable[[jax.Array, jax.Array], jax.Array]  # of the value so far and the next


class Folded(NamedTuple):
    """How a measure is computed."""

    value: Callable[[Moment], Any]  # at a moment, ()
    fold: Fold


EVER = Fold(False, jnp.logical_or)
LEAST = Fold(jnp.inf, jnp.minimum)
TOTAL = Fold(0, jnp.add)
LAST = Fold(0, lambda so_far, value: value)


def nearest_cube(moment: Moment) -> jax.Array:
    """Metres from the pinch point to the nearest cube's centre, ()."""
    return jnp.linalg.norm(moment.cubes - moment.pinch, axis=-1).min()


def farthest_target(moment: Moment) -> jax.Array:
    """Largest distance in metres of a cube from its target, ()."""
    return jnp.linalg.norm(moment.cubes - moment.target, axis=-1).max()


def touched(moment: Moment) -> jax.Array:
    """Whether the right finger's pad feels a force near a cube, () bool."""
    return feels(moment.pad_force, moment.pinch, moment.cubes, within=TOUCHING_DISTANCE).any()


def _held(moment: Moment) -> jax.Array:
    """Which cubes are held, (num_cubes,) bool."""
    return feels(moment.pad_force, moment.pinch, moment.cubes, within=HOLDING_DISTANCE)


def held(moment: Moment) -> jax.Array:
    """Whether a cube is held, () bool."""
    return _held(moment).any()


def lifted(moment: Moment) -> jax.Array:
    """Whether a cube is held at least LIFT above its initial position, () bool."""
    return jnp.any(_held(moment) & (moment.cubes[:, 2] - moment.start[:, 2] >= LIFT))


def within(distance: float) -> Callable[[Moment], jax.Array]:
    """Whether every cube is within `distance` metres of its target, () bool."""
    return lambda moment: farthest_target(moment) <= distance


def final_distance(moment: Moment) -> jax.Array:
    """Like `farthest_target`; NaN once the simulation has diverged, since it then has no end."""
    return jnp.where(moment.diverged, jnp.nan, farthest_target(moment))


FOLDED: Mapping[str, Folded] = {
    "nearest": Folded(nearest_cube, LEAST),
    "touched": Folded(touched, EVER),
    "held": Folded(held, EVER),
    "lifted": Folded(lifted, EVER),
    "within_10cm": Folded(within(0.10), EVER),
    "within_5cm": Folded(within(0.05), EVER),
    "success": Folded(lambda moment: moment.success, LAST),
    "within_3cm": Folded(within(0.03), EVER),
    "final_distance": Folded(final_distance, LAST),
    "length": Folded(lambda moment: 1, TOTAL),
    "diverged": Folded(lambda moment: moment.diverged, LAST),
}
"""By measure: its value at a moment, and how these values are combined into the episode's."""


def begin() -> Values:
    """The values of an episode before its first step."""
    return {
        name: jnp.asarray(folded.fold.start, MEASURES[name].kind) for name, folded in FOLDED.items()
    }


def advance(so_far: Values, moment: Moment, active: jax.Array) -> Values:
    """The values after one more step; those of an inactive episode are unchanged."""
    values = {
        name: jnp.asarray(folded.value(moment), MEASURES[name].kind)
        for name, folded in FOLDED.items()
    }
    return {
        name: jnp.where(active, folded.fold.combine(so_far[name], values[name]), so_far[name])
        for name, folded in FOLDED.items()
    }


def cubes(env: "envs.CubeEnv", state: "envs.State") -> jax.Array:
    """The positions of the cubes in one simulation, (num_cubes, 3) metres."""
    return cube_poses(env.scene, _physics(state))[0]


def moment(env: "envs.CubeEnv", state: "envs.State", start: jax.Array) -> Moment:
    """The input of measures from one simulation; `start` is its cubes' initial positions."""
    physics_state = _physics(state)
    return Moment(
        start=start,
        cubes=cubes(env, state),
        target=state.info["target"],
        pinch=physics_state.pinch_pos,
        pad_force=physics_state.pad_force,
        success=state.info["success"],
        diverged=state.info["diverged"],
    )


def _physics(state: "envs.State") -> PhysicsState:
    return state.pipeline_state  # pyright: ignore[reportReturnType]
