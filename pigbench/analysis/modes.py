"""Contact modes, inferred from observations alone."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Shaped

from pigbench.envs import servo
from pigbench.envs.contact import FREE, HOLDING, HOLDING_DISTANCE, TOUCHING, feels
from pigbench.envs.units import metres
from pigbench.layout import Layout

MODES = FREE, TOUCHING, HOLDING


def contact_modes(
    observations: Float[np.ndarray, "batch observation"], layout: Layout
) -> Shaped[np.ndarray, "batch"]:
    """The mode of each observation, a string of `MODES`.

    The finger pad feels no force (free), a force with a cube around the pinch point (holding), or a
    force without one (touching).
    """
    contact = observations[:, layout["gripper_contact"]][:, 0]
    places = layout.group("object_positions").values()
    cubes = [metres(observations[:, part]) for part in places]
    pinch = pinch_points(observations, layout)
    held = feels(contact, pinch, np.stack(cubes, axis=1), within=HOLDING_DISTANCE)
    return np.select([held.any(axis=-1), contact > 0], [HOLDING, TOUCHING], FREE)


def pinch_points(
    observations: Float[np.ndarray, "batch observation"], layout: Layout
) -> Float[np.ndarray, "batch 3"]:
    """The pinch point of each observation in metres; from the joints if need be."""
    if "effector_pos" in layout:
        return metres(observations[:, layout["effector_pos"]])
    joints = jnp.asarray(observations[:, layout["joint_pos"]])
    return np.asarray(jax.jit(jax.vmap(servo.pinch))(joints)[0])
