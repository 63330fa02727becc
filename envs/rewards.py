"""A table of rewards, each a small function of the situation after a step.

The benchmark's reward is sparse. The dense ones are for reinforcement learning from scratch: they
are costs in metres, so that an episode that ends early with success costs less.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import jax
import jax.numpy as jnp


class Situation(NamedTuple):
    """One simulation after a control step; positions are in metres."""

    pinch: jax.Array  # (3,)
    cubes: jax.Array  # (num_cubes, 3)
    target: jax.Array  # (num_cubes, 3)
    placed: jax.Array  # (num_cubes,) bool: at its target
    success: jax.Array  # () bool


def sparse(situation: Situation) -> jax.Array:
    """1 on success, else 0."""
    return situation.success.astype(jnp.float32)


def reach(situation: Situation) -> jax.Array:
    """Minus the distance from the pinch point to the nearest cube."""
    return -_distances(situation.cubes, situation.pinch).min()


def place(situation: Situation) -> jax.Array:
    """Minus the sum of the cubes' distances to their targets, and minus the pinch point's distance
    to the nearest cube that is not at its target, if there is one.
    """
    to_pinch = _distances(situation.cubes, situation.pinch)
    nearest = jnp.where(situation.placed, jnp.inf, to_pinch).min()
    reaching = jnp.where(situation.placed.all(), 0.0, nearest)
    return -_distances(situation.cubes, situation.target).sum() - reaching


def _distances(points: jax.Array, others: jax.Array) -> jax.Array:
    return jnp.linalg.norm(points - others, axis=-1)


REWARDS: Mapping[str, Callable[[Situation], jax.Array]] = {
    "sparse": sparse,
    "reach": reach,
    "place": place,
}
