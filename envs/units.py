"""The units of positions in an observation: known without JAX."""

from typing import TYPE_CHECKING, TypeVar

import numpy as np

if TYPE_CHECKING:
    import jax

# They bring positions to order one, as in OGBench.
CENTRE = (0.425, 0.0, 0.0)
POSITION_SCALE = 10.0

Array = TypeVar("Array", "jax.Array", np.ndarray)


def metres(position: Array) -> Array:
    """A term's position (..., 3) in metres."""
    return position / POSITION_SCALE + np.array(CENTRE)
