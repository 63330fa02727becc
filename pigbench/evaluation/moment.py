"""The state of an evaluation episode at one moment, of which measures are functions."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from pigbench.envs.contact import HOLDING_DISTANCE, TOUCHING_DISTANCE, feels


class Moment(NamedTuple):
    """One simulation after a control step, positions in metres."""

    start: Float[Array, "cube 3"]  # the cubes at the start of the episode
    cubes: Float[Array, "cube 3"]
    target: Float[Array, "cube 3"]
    pinch: Float[Array, "3"]
    pad_force: Float[Array, ""]  # of the wrench on the right finger's pad
    success: Bool[Array, ""]
    diverged: Bool[Array, ""]  # if true, the rest is from the last good state

    @property
    def from_pinch(self) -> Float[Array, "cube"]:
        """Metres from the pinch point to each cube's centre."""
        return jnp.linalg.norm(self.cubes - self.pinch, axis=-1)

    @property
    def from_targets(self) -> Float[Array, "cube"]:
        """Metres from each cube to its target."""
        return jnp.linalg.norm(self.cubes - self.target, axis=-1)

    @property
    def raised(self) -> Float[Array, "cube"]:
        """Metres of each cube above its initial position."""
        return self.cubes[:, 2] - self.start[:, 2]

    @property
    def touched(self) -> Bool[Array, "cube"]:
        """Near which cubes the right finger's pad feels a force."""
        return feels(self.pad_force, self.pinch, self.cubes, within=TOUCHING_DISTANCE)

    @property
    def held(self) -> Bool[Array, "cube"]:
        """Which cubes are held."""
        return feels(self.pad_force, self.pinch, self.cubes, within=HOLDING_DISTANCE)

    def unless_diverged(self, value: Float[Array, ""]) -> Float[Array, ""]:
        """`value`; NaN once the simulation has diverged, since it then has no end."""
        return jnp.where(self.diverged, jnp.nan, value)
