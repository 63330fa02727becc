"""The computation of `MEASURES`: each is folded over an evaluation episode."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Shaped

from pigbench import envs
from pigbench.envs.observation import cube_poses
from pigbench.evaluation.measures import MEASURES, Fold, Value
from pigbench.evaluation.moment import Moment

ArrayValue = Shaped[Array, ""]
ArrayValues = dict[str, ArrayValue]  # by measure


class Folding(NamedTuple):
    """The computation of a fold."""

    start: Value
    combine: Callable[[ArrayValue, ArrayValue], ArrayValue]  # of the value so far and the next


FOLDINGS: Mapping[Fold, Folding] = {
    Fold.EVER: Folding(False, jnp.logical_or),
    Fold.LEAST: Folding(jnp.inf, jnp.minimum),
    Fold.MOST: Folding(-jnp.inf, jnp.maximum),
    Fold.TOTAL: Folding(0, jnp.add),
    Fold.LAST: Folding(0, lambda so_far, value: value),
}


def begin() -> ArrayValues:
    """The values of an episode before its first step."""
    return {
        name: jnp.asarray(FOLDINGS[measure.fold].start, measure.kind)
        for name, measure in MEASURES.items()
    }


def advance(so_far: ArrayValues, moment: Moment, active: Bool[Array, ""]) -> ArrayValues:
    """The values after one more step; those of an inactive episode are unchanged."""

    def after(name: str, value: ArrayValue) -> ArrayValue:
        measure = MEASURES[name]
        now = jnp.asarray(measure.value(moment), measure.kind)
        return jnp.where(active, FOLDINGS[measure.fold].combine(value, now), value)

    return {name: after(name, value) for name, value in so_far.items()}


def cubes(env: "envs.CubeEnv", state: "envs.State") -> Float[Array, "cube 3"]:
    """The positions of the cubes in one simulation in metres."""
    return cube_poses(env.scene, env.simulation(state))[0]


def moment(env: "envs.CubeEnv", state: "envs.State", start: Float[Array, "cube 3"]) -> Moment:
    """The input of measures from one simulation; `start` is its cubes' initial positions."""
    physics_state = env.simulation(state)
    return Moment(
        start=start,
        cubes=cubes(env, state),
        target=state.info["target"],
        pinch=physics_state.pinch_pos,
        pad_force=physics_state.pad_force,
        success=state.info["success"],
        diverged=state.info["diverged"],
    )
