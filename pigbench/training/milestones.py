"""How far an evaluation episode came: a table of measures, each a column of `episodes.csv`.

A measure is a small function of one simulation after a control step, folded over the episode. What
the rollout evaluates, the file holds and tables, figures and progress show follows from the table:
a new measure is a row in it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import jax.numpy as jnp

from pigbench.envs.contact import HOLDING_DISTANCE, TOUCHING_DISTANCE, feels
from pigbench.envs.observation import cube_poses
from pigbench.envs.physics import PhysicsState

if TYPE_CHECKING:
    from pigbench.envs import CubeEnv, State

LIFT = 0.02
"""Metres above its start from which a cube is lifted: one tipped over an edge rises by 0.8 cm, over
a corner by 1.5 cm."""

Value = bool | int | float
Values = dict[str, jax.Array]  # by measure


class Moment(NamedTuple):
    """One simulation after a control step, positions in metres."""

    start: jax.Array  # (num_cubes, 3) the cubes when the episode began
    cubes: jax.Array  # (num_cubes, 3)
    target: jax.Array  # (num_cubes, 3)
    pinch: jax.Array  # (3,)
    pad_force: jax.Array  # ()
    success: jax.Array  # () bool
    diverged: jax.Array  # () bool: the rest is the last good state


class Fold(NamedTuple):
    """How a measure's values after each step become the episode's."""

    start: Value
    combine: Callable[[jax.Array, jax.Array], jax.Array]  # of the value so far and the next


EVER = Fold(False, jnp.logical_or)
LEAST = Fold(jnp.inf, jnp.minimum)
TOTAL = Fold(0, jnp.add)
LAST = Fold(0, lambda so_far, value: value)


@dataclass(frozen=True)
class Measure:
    """One number of an episode.

    Attributes:
        name: its column.
        label: its name in tables and figures, with the unit if that is not percent.
        value: its value at a moment, ().
        fold: how the values of an episode become one.
        kind: the type of that one.
        scale: what its mean over episodes is multiplied by where it is shown.
        stage: whether it is one of the stages from touching a cube to success.
    """

    name: str
    label: str
    value: Callable[[Moment], Any]
    fold: Fold
    kind: type[Value] = bool
    scale: float = 100.0
    stage: bool = False


def nearest_cube(moment: Moment) -> jax.Array:
    """Metres from the pinch point to the nearest cube's centre, ()."""
    return jnp.linalg.norm(moment.cubes - moment.pinch, axis=-1).min()


def farthest_target(moment: Moment) -> jax.Array:
    """Metres from the cube that is farthest from its target to that target, ()."""
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
    """Whether a cube is held LIFT or more above where it began, () bool."""
    return jnp.any(_held(moment) & (moment.cubes[:, 2] - moment.start[:, 2] >= LIFT))


def within(distance: float) -> Callable[[Moment], jax.Array]:
    """Whether every cube lies within so many metres of its target, () bool."""
    return lambda moment: farthest_target(moment) <= distance


def final_distance(moment: Moment) -> jax.Array:
    """As `farthest_target`; not a number once the simulation has diverged, which has no end."""
    return jnp.where(moment.diverged, jnp.nan, farthest_target(moment))


MEASURES: Mapping[str, Measure] = {
    measure.name: measure
    for measure in (
        Measure("nearest", "nearest (cm)", nearest_cube, LEAST, float),
        Measure("touched", "touched", touched, EVER, stage=True),
        Measure("held", "held", held, EVER, stage=True),
        Measure("lifted", "lifted", lifted, EVER, stage=True),
        Measure("within_10cm", "within 10 cm", within(0.10), EVER, stage=True),
        Measure("within_5cm", "within 5 cm", within(0.05), EVER, stage=True),
        Measure("success", "success", lambda moment: moment.success, LAST, stage=True),
        # No stage: success, at 4 cm, ends an episode, so few come nearer.
        Measure("within_3cm", "within 3 cm", within(0.03), EVER),
        Measure("final_distance", "final (cm)", final_distance, LAST, float),
        Measure("length", "steps", lambda moment: 1, TOTAL, int, scale=1.0),
        Measure("diverged", "diverged", lambda moment: moment.diverged, LAST),
    )
}
"""In the order of columns. Distances are in metres; the state that an episode begins in does not
count, as it does not for success; of a diverged episode counts what it reached before."""

BRIEF = "success", "held", "lifted"
"""Measures in the line of a training's progress."""


def begin() -> Values:
    """The values of an episode of no steps."""
    return {
        name: jnp.asarray(measure.fold.start, measure.kind) for name, measure in MEASURES.items()
    }


def advance(so_far: Values, moment: Moment, active: jax.Array) -> Values:
    """The values with the moment after one more step; those of an inactive episode as they are."""
    return {
        name: jnp.where(
            active,
            measure.fold.combine(so_far[name], jnp.asarray(measure.value(moment), measure.kind)),
            so_far[name],
        )
        for name, measure in MEASURES.items()
    }


def cubes(env: "CubeEnv", state: "State") -> jax.Array:
    """Where the cubes of one simulation are, (num_cubes, 3) in metres."""
    return cube_poses(env.scene, _physics(state))[0]


def moment(env: "CubeEnv", state: "State", start: jax.Array) -> Moment:
    """One simulation as measures see it; `start` is where its cubes began."""
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


def _physics(state: "State") -> PhysicsState:
    return state.pipeline_state  # pyright: ignore[reportReturnType]
