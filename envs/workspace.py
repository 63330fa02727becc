"""The regions in which the robot works and cubes are placed, in metres in the world frame."""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray


@dataclass(frozen=True)
class Box:
    """An axis-aligned box."""

    low: tuple[float, ...]
    high: tuple[float, ...]

    @property
    def middle(self) -> tuple[float, ...]:
        """Its centre."""
        return tuple((low + high) / 2 for low, high in zip(self.low, self.high, strict=True))

    def sample(
        self, key: PRNGKeyArray, shape: tuple[int, ...] = ()
    ) -> Float[Array, "*shape dimension"]:
        """Uniform points."""
        return self.point(jax.random.uniform(key, (*shape, len(self.low))))

    def point(self, unit: Float[Array, "*batch dimension"]) -> Float[Array, "*batch dimension"]:
        """The point at coordinates in [0, 1] from the low to the high corner."""
        low, high = jnp.array(self.low), jnp.array(self.high)
        return low + unit * (high - low)

    def clip(self, point: Float[Array, "*batch dimension"]) -> Float[Array, "*batch dimension"]:
        """The nearest point of the box."""
        return jnp.clip(point, jnp.array(self.low), jnp.array(self.high))


PINCH = Box((0.25, -0.35, 0.02), (0.6, 0.35, 0.35))
PINCH_START = Box((0.25, -0.35, 0.20), (0.6, 0.35, 0.35))
CUBE = Box((0.3, -0.3), (0.55, 0.3))
