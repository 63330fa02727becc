"""Which way a state moves, for residuals that look along observed motion (the paper's Eq. HJB).

The direction is u = dx / (||dx|| + epsilon). What counts as motion, and in what its length is
measured, is a choice: joint velocities, for one, make most of a squared displacement.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple, Protocol

import jax
import numpy as np

from pigbench.agents.norms import safe_norm
from pigbench.agents.statistics import Statistics, require
from pigbench.errors import lookup


class Motion(Protocol):
    """Which way states move."""

    def __call__(
        self, states: jax.Array, next_states: jax.Array, /, *, epsilon: float
    ) -> jax.Array:
        """u, 0 where nothing moves: (B, n) and (B, n) to (B, n)."""
        ...


class Direction(NamedTuple):
    """u of a displacement: of the coordinates that are `moving`, each as long as `units` say."""

    moving: np.ndarray | float = 1.0  # (n,): 1 where a coordinate counts as motion, else 0
    units: np.ndarray | float = 1.0  # (n,): the length of a coordinate's unit

    def __call__(self, states: jax.Array, next_states: jax.Array, *, epsilon: float) -> jax.Array:
        """(..., n) and (..., n) to (..., n); 0 where nothing moves."""
        moves = (next_states - states) * self.moving
        return moves / (safe_norm(moves * self.units)[..., None] + epsilon)


class Coordinates(NamedTuple):
    """What an agent sees of a state.

    `statistics` are in its own coordinates; a unit of these is `units` of the observation's, (n,).
    """

    layout: Mapping[str, slice]
    statistics: Statistics | None
    units: np.ndarray | float = 1.0


def _positions(coordinates: Coordinates) -> Direction:
    size = max(part.stop for part in coordinates.layout.values())
    moving = np.ones(size, np.float32)
    for term, part in coordinates.layout.items():
        if term.endswith("_vel"):
            moving[part] = 0
    return Direction(moving=moving)


def _standardized(coordinates: Coordinates) -> Direction:
    statistics = require(coordinates.statistics, "direction 'standardized'")
    return Direction(units=1 / statistics.deviation)


DIRECTIONS: Mapping[str, Callable[[Coordinates], Direction]] = {
    "own": lambda coordinates: Direction(),
    "raw": lambda coordinates: Direction(units=coordinates.units),
    "standardized": _standardized,
    "positions": _positions,
}
"""What motion is measured in: the agent's own coordinates, as they are or without velocities; the
observation's; or deviations of the data."""


def make(name: str, coordinates: Coordinates) -> Direction:
    """The direction of that name; `UserError` if there is none, or it lacks statistics."""
    return lookup("direction", DIRECTIONS, name)(coordinates)
