"""The units of observations and actions, available without importing JAX."""

from typing import TYPE_CHECKING, TypeVar

import numpy as np

if TYPE_CHECKING:
    import jax

# These bring every term to order 1, as in OGBench.
CENTRE = (0.425, 0.0, 0.0)
POSITION_SCALE = 10.0
OPENING_SCALE = 3.0
PAD_FORCE_SCALE = 1 / 50

CONTROL_STEP = 0.05  # seconds

# The move of an action of 1 in one control step: metres (x, y, z), radians of yaw, opening.
ACTION_NAMES = ("x", "y", "z", "yaw", "gripper")
ACTION_SCALE = (0.05, 0.05, 0.05, 0.3, 1.0)
ACTION_SIZE = len(ACTION_SCALE)

Array = TypeVar("Array", "jax.Array", np.ndarray)


def metres(position: Array) -> Array:
    """The position (..., 3) of an observation term, in metres."""
    return position / POSITION_SCALE + np.array(CENTRE)
