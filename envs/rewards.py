"""A table of rewards, each a small function of the situation after a step.

The benchmark's reward is sparse. The dense ones are for reinforcement learning from scratch: they
are costs in metres, so that an episode that ends early with success costs less.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float


class Situation(NamedTuple):
    """One simulation after a control step; positions are in metres."""

    pinch: Float[Array, "3"]
    cubes: Float[Array, "cube 3"]
    target: Float[Array, "cube 3"]
    placed: Bool[Array, "cube"]  # at its target
    success: Bool[Array, ""]


def sparse(situation: Situation) -> Float[Array, ""]:
    """1 on success, else 0."""
    return situation.success.astype(jnp.float32)


def reach(situation: Situation) -> Float[Array, ""]:
    """Minus the distance from the pinch point to the nearest cube."""
    return -_distances(situation.cubes, situation.pinch).min()


def place(situation: Situation) -> Float[Array, ""]:
    """Minus the sum of the cubes' distances to their targets, and minus the pinch point's distance
    to the nearest cube that is not at its target, if there is one.
    """
    to_pinch = _distances(situation.cubes, situation.pinch)
    nearest = jnp.where(situation.placed, jnp.inf, to_pinch).min()
    reaching = jnp.where(situation.placed.all(), 0.0, nearest)
    return -_distances(situation.cubes, situation.target).sum() - reaching


def _distances(
    points: Float[Array, "cube 3"], others: Float[Array, "cube 3"] | Float[Array, "3"]
) -> Float[Array, "cube"]:
    return jnp.linalg.norm(points - others, axis=-1)


REWARDS: Mapping[str, Callable[[Situation], Float[Array, ""]]] = {
    "sparse": sparse,
    "reach": reach,
    "place": place,
}
