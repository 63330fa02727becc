"""Whether the gripper touches or holds a cube, from the force on its pad and from positions."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

FREE, TOUCHING, HOLDING, CARRYING = "free", "touching", "holding", "carrying"
"""What the gripper does: its pad feels no force, a force, one with a cube around the pinch point,
or one with a cube in the air."""

HOLDING_DISTANCE = 0.02
"""Metres from the pinch point to a cube's centre within which it is held: half a cube's edge."""

TOUCHING_DISTANCE = 0.04
"""Metres within which it is touched. A force farther from all cubes comes from the fingers touching
each other: in 98 % of such rows of play data, they are shut."""


def feels(
    force: Float[Array | np.ndarray, "*batch"],
    pinch: Float[Array | np.ndarray, "*batch 3"],
    cubes: Float[Array | np.ndarray, "*batch cube 3"],
    *,
    within: float,
) -> Bool[Array, "*batch cube"]:
    """Whether there is a force on the pad and the pinch point is `within` metres of each cube.

    `force` is that on the right finger's pad, in any unit. Positions are in metres.
    """
    near = jnp.linalg.norm(cubes - pinch[..., None, :], axis=-1) < within
    return near & (force > 0)[..., None]
