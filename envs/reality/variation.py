"""Dynamics that vary between the episodes of a real robot: friction and mass."""

import jax
from jaxtyping import PRNGKeyArray

from pigbench.envs.physics import Factors
from pigbench.envs.reality import Variation


def draw(key: PRNGKeyArray, variation: Variation) -> Factors:
    """The factors of an episode, each drawn uniformly."""
    friction, mass = jax.random.uniform(key, (2,), minval=-1.0)
    return Factors(friction=1 + variation.friction * friction, mass=1 + variation.mass * mass)
