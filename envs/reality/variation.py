"""What differs from one real episode to the next: how rough things are, and how heavy."""

from dataclasses import dataclass

import jax

from pigbench.envs.physics import Factors


@dataclass(frozen=True)
class Variation:
    """How far an episode's dynamics may lie from the model's; 0 is not at all.

    Attributes:
        friction: the largest change of the friction of all contacts, as a share of it.
        mass: that of the cubes' masses and inertias.
    """

    friction: float = 0.0
    mass: float = 0.0


def draw(key: jax.Array, variation: Variation) -> Factors:
    """An episode's factors, each uniform."""
    friction, mass = jax.random.uniform(key, (2,), minval=-1.0)
    return Factors(friction=1 + variation.friction * friction, mass=1 + variation.mass * mass)
