"""Dynamics that vary between the episodes of a real robot: friction and mass."""

from dataclasses import dataclass

import jax

from pigbench.envs.physics import Factors


@dataclass(frozen=True)
class Variation:
    """How far an episode's dynamics may deviate from the model's; 0 means not at all.

    Attributes:
        friction: the largest relative change of the friction of all contacts.
        mass: the largest relative change of the cubes' masses and inertias.
    """

    friction: float = 0.0
    mass: float = 0.0


def draw(key: jax.Array, variation: Variation) -> Factors:
    """The factors of an episode, each drawn uniformly."""
    friction, mass = jax.random.uniform(key, (2,), minval=-1.0)
    return Factors(friction=1 + variation.friction * friction, mass=1 + variation.mass * mass)
