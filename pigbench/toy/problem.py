"""The parts of an example: motions in the plane with a closed-form cost-to-go."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Float

from pigbench.shapes import Array

States = Float[Array, "batch 2"]
Costs = Float[Array, "batch"]

STEP = 0.01
"""Time between a state and its successor; residuals use only the direction of the motion."""


class ToySection(NamedTuple):
    """A line through the square [-1, 1]^2, along which fits are plotted over the second coordinate.

    `label` may refer to the start, scaled to the square in use, as "{0:g}" and "{1:g}".
    """

    label: str
    start: tuple[float, float]
    end: tuple[float, float]

    def points(self, count: int) -> Float[Array, "{count} 2"]:
        """`count` points along the line."""
        return jnp.linspace(jnp.array(self.start), jnp.array(self.end), count)


@dataclass(frozen=True)
class Mode:
    """Motion in one contact mode at unit running cost."""

    name: str
    cost_to_go: Callable[[States], Costs]  # d*(s, g), with the goal at the origin
    successor: Callable[[States], States]  # s' after `STEP` of optimal motion
    kink_distance: Callable[[States], Float[Array, "batch"]]  # to where d* has no gradient
    section: ToySection


@dataclass(frozen=True)
class Example:
    """Fits to make, each of one network, whose inputs are a state and the number of its mode."""

    axes: tuple[str, str]
    fits: tuple[tuple[Mode, ...], ...]
