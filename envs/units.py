"""The units of an observation's terms, available without importing JAX."""

from typing import TYPE_CHECKING, TypeVar

import numpy as np

if TYPE_CHECKING:
    import jax

# These bring every term to order 1, as in OGBench.
CENTRE = (0.425, 0.0, 0.0)
POSITION_SCALE = 10.0
OPENING_SCALE = 3.0
PAD_FORCE_SCALE = 1 / 50

Array = TypeVar("Array", "jax.Array", np.ndarray)


def metres(position: Array) -> Array:
    """The position (..., 3) of an observation term, in metres."""
    return position / POSITION_SCALE + np.array(CENTRE)
