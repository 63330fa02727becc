"""The computation of `MEASURES`, which say how far an evaluation episode got."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import jax
import jax.numpy as jnp

from pigbench import envs
from pigbench.envs.contact import HOLDING_DISTANCE, TOUCHING_DISTANCE, feels
from pigbench.envs.observation import cube_poses
from pigbench.envs.physics import PhysicsState
from pigbench.training.measures import MEASURES, Fold, Value

Values = dict[str, jax.Array]  # by measure


class Moment(NamedTuple):
    """One simulation after a control step, positions in metres."""

    start: jax.Array  # (num_cubes, 3) the cubes at the start of the episode
    cubes: jax.Array  # (num_cubes, 3)
    target: jax.Array  # (num_cubes, 3)
    pinch: jax.Array  # (3,)
    pad_force: jax.Array  # () of the wrench on the right finger's pad
    success: jax.Array  # () bool
    diverged: jax.Array  # () bool: if true, the rest is from the last good state

    @property
    def from_pinch(self) -> jax.Array:
        """Metres from the pinch point to each cube's centre, (num_cubes,)."""
        return jnp.linalg.norm(self.cubes - self.pinch, axis=-1)

    @property
    def from_targets(self) -> jax.Array:
        """Metres from each cube to its target, (num_cubes,)."""
        return jnp.linalg.norm(self.cubes - self.target, axis=-1)

    @property
    def raised(self) -> jax.Array:
        """Metres of each cube above its initial position, (num_cubes,)."""
        return self.cubes[:, 2] - self.start[:, 2]

    @property
    def touched(self) -> jax.Array:
        """Near which cubes the right finger's pad feels a force, (num_cubes,) bool."""
        return feels(self.pad_force, self.pinch, self.cubes, within=TOUCHING_DISTANCE)

    @property
    def held(self) -> jax.Array:
        """Which cubes are held, (num_cubes,) bool."""
        return feels(self.pad_force, self.pinch, self.cubes, within=HOLDING_DISTANCE)

    def unless_diverged(self, value: jax.Array) -> jax.Array:
        """`value`; NaN once the simulation has diverged, since it then has no end."""
        return jnp.where(self.diverged, jnp.nan, value)


class Folding(NamedTuple):
    """The computation of a fold."""

    start: Value
    combine: Callable[[jax.Array, jax.Array], jax.Array]  # of the value so far and the next


FOLDINGS: Mapping[Fold, Folding] = {
    Fold.EVER: Folding(False, jnp.logical_or),
    Fold.LEAST: Folding(jnp.inf, jnp.minimum),
    Fold.MOST: Folding(-jnp.inf, jnp.maximum),
    Fold.TOTAL: Folding(0, jnp.add),
    Fold.LAST: Folding(0, lambda so_far, value: value),
}


def begin() -> Values:
    """The values of an episode before its first step."""
    return {
        name: jnp.asarray(FOLDINGS[measure.fold].start, measure.kind)
        for name, measure in MEASURES.items()
    }


def advance(so_far: Values, moment: Moment, active: jax.Array) -> Values:
    """The values after one more step; those of an inactive episode are unchanged."""

    def after(name: str, value: jax.Array) -> jax.Array:
        measure = MEASURES[name]
        now = jnp.asarray(measure.value(moment), measure.kind)
        return jnp.where(active, FOLDINGS[measure.fold].combine(value, now), value)

    return {name: after(name, value) for name, value in so_far.items()}


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
