"""The parts of an example: motions in the plane with a closed-form cost-to-go."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp

STEP = 0.01
"""Time between a state and its successor; residuals use only the direction of the motion."""


class ToySection(NamedTuple):
    """A line through the square [-1, 1]^2, along which fits are plotted over the second coordinate.

    `label` may refer to the start, scaled to the square in use, as "{0:g}" and "{1:g}".
    """

    label: str
    start: tuple[float, float]
    end: tuple[float, float]

    def points(self, count: int) -> jax.Array:
        """`count` points along the line, (count, 2)."""
        return jnp.linspace(jnp.array(self.start), jnp.array(self.end), count)


@dataclass(frozen=True)
class Mode:
    """Motion in one contact mode at unit running cost. Functions take states (B, 2)."""

    name: str
    cost_to_go: Callable[[jax.Array], jax.Array]  # d*(s, g), (B,), with the goal at the origin
    successor: Callable[[jax.Array], jax.Array]  # s' after `STEP` of optimal motion, (B, 2)
    kink_distance: Callable[[jax.Array], jax.Array]  # (B,) to where d* has no gradient
    section: ToySection


@dataclass(frozen=True)
class Example:
    """Fits to make, each of one network, whose inputs are a state and the number of its mode."""

    axes: tuple[str, str]
    fits: tuple[tuple[Mode, ...], ...]
