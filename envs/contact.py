"""What the gripper does to cubes, told from the force on its pad and from where things are."""

import jax
import jax.numpy as jnp
import numpy as np

HOLDING_DISTANCE = 0.02
"""Metres from the pinch point to the centre of a cube that is held: half of the cube's edge."""

TOUCHING_DISTANCE = 0.04
"""Metres likewise of a cube that is touched. Farther from all cubes, the fingers touch each other:
of the rows of play data with a force there, 98 % have them shut."""

Array = jax.Array | np.ndarray


def feels(force: Array, pinch: Array, cubes: Array, *, within: float) -> jax.Array:
    """Whether the pad feels a force with the pinch point `within` so many metres of each cube.

    Args:
        force: (...) on the right finger's pad, in any unit.
        pinch: (..., 3) metres.
        cubes: (..., num_cubes, 3) metres.

    Returns:
        (..., num_cubes) bool.
    """
    near = jnp.linalg.norm(cubes - pinch[..., None, :], axis=-1) < within
    return near & (force > 0)[..., None]
