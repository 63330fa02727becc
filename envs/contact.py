"""Whether the gripper touches or holds a cube, from the force on its pad and from positions."""

import jax
import jax.numpy as jnp
import numpy as np

HOLDING_DISTANCE = 0.02
"""Metres from the pinch point to a cube's centre within which it is held: half a cube's edge."""

TOUCHING_DISTANCE = 0.04
"""Metres within which it is touched. A force farther from all cubes comes from the fingers touching
each other: in 98 % of such rows of play data, they are shut."""

Array = jax.Array | np.ndarray


def feels(force: Array, pinch: Array, cubes: Array, *, within: float) -> jax.Array:
    """Whether there is a force on the pad and the pinch point is `within` metres of each cube.

    Args:
        force: (...) on the right finger's pad, in any unit.
        pinch: (..., 3) metres.
        cubes: (..., num_cubes, 3) metres.

    Returns:
        (..., num_cubes) bool.
    """
    near = jnp.linalg.norm(cubes - pinch[..., None, :], axis=-1) < within
    return near & (force > 0)[..., None]
