"""Directions of motion, for residuals along observed transitions.

The direction is u = dx / (||dx|| + epsilon), as in "Contact-aware physics-informed value learning"
in the paper. Which coordinates count as motion, and in which units its length is measured, is a
choice: joint velocities, for example, account for most of a squared displacement.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from pigbench.agents.norms import safe_norm
from pigbench.agents.statistics import Statistics, require_statistics
from pigbench.errors import lookup
from pigbench.layout import Layout
from pigbench.shapes import Array


class Direction(NamedTuple):
    """u of a displacement in the `moving` coordinates, with its length measured in `units`."""

    moving: Float[np.ndarray, "n"] | float = 1.0  # 1 where a coordinate counts as motion, else 0
    units: Float[np.ndarray, "n"] | float = 1.0  # the length of one unit of each coordinate

    def __call__(
        self,
        states: Float[Array, "batch n"],
        next_states: Float[Array, "batch n"],
        *,
        epsilon: float,
    ) -> Float[Array, "batch n"]:
        """u, which is 0 where nothing moves."""
        moves = (next_states - states) * self.moving
        return moves / (safe_norm(moves * self.units)[..., None] + epsilon)


class Coordinates(NamedTuple):
    """The coordinates in which an agent sees a state.

    `statistics` are in these coordinates; one unit of them is `units` of the observation's.
    """

    layout: Layout
    statistics: Statistics | None
    units: Float[np.ndarray, "n"] | float = 1.0


def _positions(coordinates: Coordinates) -> Direction:
    moving = np.ones(coordinates.layout.size, np.float32)
    for part in coordinates.layout.group("velocities").values():
        moving[part] = 0
    return Direction(moving=moving)


def _standardized(coordinates: Coordinates) -> Direction:
    statistics = require_statistics(coordinates.statistics, "direction 'standardized'")
    return Direction(units=1 / statistics.deviation)


DIRECTIONS: Mapping[str, Callable[[Coordinates], Direction]] = {
    "own": lambda coordinates: Direction(),  # in the coordinates that the agent sees
    "raw": lambda coordinates: Direction(units=coordinates.units),  # in those of the observation
    "standardized": _standardized,  # in standard deviations of the data
    "positions": _positions,  # in the agent's, without velocities
}
"""How motion is measured."""


def make(name: str, coordinates: Coordinates) -> Direction:
    """The direction called `name`; `UserError` if there is none or its statistics are missing."""
    return lookup("direction", DIRECTIONS, name)(coordinates)
