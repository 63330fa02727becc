"""What an example is made of: motions in the plane with a closed-form cost-to-go."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp

STEP = 0.01
"""Time between a state and its successor; residuals see the direction of the motion only."""


class Section(NamedTuple):
    """A line through the square [-1, 1]^2, along which fits are drawn over the second coordinate.

    `label` may name the start, scaled to the square in use, by "{0:g}" and "{1:g}".
    """

    label: str
    start: tuple[float, float]
    end: tuple[float, float]

    def points(self, count: int) -> jax.Array:
        """(count, 2)."""
        return jnp.linspace(jnp.array(self.start), jnp.array(self.end), count)


@dataclass(frozen=True)
class Mode:
    """Motion in one contact mode at unit running cost. Functions take states (B, 2)."""

    name: str
    cost_to_go: Callable[[jax.Array], jax.Array]  # d*(s, g), (B,), with the goal at the origin
    successor: Callable[[jax.Array], jax.Array]  # s' after `STEP` of optimal motion, (B, 2)
    kink_distance: Callable[[jax.Array], jax.Array]  # (B,) from where d* has no gradient
    section: Section


@dataclass(frozen=True)
class Example:
    """Fits to make, one network each, which sees a state and the number of its mode."""

    axes: tuple[str, str]
    fits: tuple[tuple[Mode, ...], ...]
