"""Angles in radians, quaternions (w, x, y, z) and rotation matrices."""

from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float


def wrap(angle: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
    """The same angle in [-pi, pi)."""
    return jnp.mod(angle + jnp.pi, 2 * jnp.pi) - jnp.pi


def nearest_turn(
    angle: Float[Array, "*batch"], reference: Float[Array, "*batch"]
) -> Float[Array, "*batch"]:
    """The same angle, shifted by whole turns to be nearest to `reference`."""
    return reference + wrap(angle - reference)


def yaw_quat(yaw: Float[Array, "*batch"]) -> Float[Array, "*batch 4"]:
    """The quaternion of a rotation by `yaw` about z."""
    zero = jnp.zeros_like(yaw)
    return jnp.stack([jnp.cos(yaw / 2), zero, zero, jnp.sin(yaw / 2)], axis=-1)


def quat_product(
    one: Float[Array, "*batch 4"], other: Float[Array, "*batch 4"]
) -> Float[Array, "*batch 4"]:
    """The quaternion of `other` followed by `one`."""
    a, b, c, d = jnp.moveaxis(one, -1, 0)
    w, x, y, z = jnp.moveaxis(other, -1, 0)
    return jnp.stack(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ],
        axis=-1,
    )


def quat_yaw(quat: Float[Array, "*batch 4"]) -> Float[Array, "*batch"]:
    """The yaw of a quaternion, as one of the roll-pitch-yaw angles."""
    w, x, y, z = jnp.moveaxis(quat, -1, 0)
    return jnp.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def nearest_symmetry(
    yaw: Float[Array, "*batch"], reference: Float[Array, "*batch"]
) -> Float[Array, "*batch"]:
    """The yaw nearest to `reference` at which a cube looks as it does at `yaw`."""
    step = jnp.pi / 2
    return yaw + step * jnp.round((reference - yaw) / step)


def quat_rotation(quat: Sequence[float]) -> Float[np.ndarray, "3 3"]:
    """The rotation matrix of a constant quaternion of any nonzero length."""
    single = np.asarray(quat, np.float32)
    w, x, y, z = single / np.sqrt(np.sum(single**2))
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def axis_rotation(axis: Sequence[float], angle: Float[Array, ""]) -> Float[Array, "3 3"]:
    """The rotation matrix by `angle` about a constant unit `axis`."""
    x, y, z = axis
    across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], np.float32)
    return jnp.eye(3) + jnp.sin(angle) * across + (1 - jnp.cos(angle)) * across @ across


def rotation_vector(rotation: Float[Array, "3 3"]) -> Float[Array, "3"]:
    """The axis times the angle of a rotation matrix of less than half a turn."""
    twice_sine = jnp.stack(
        [
            rotation[2, 1] - rotation[1, 2],
            rotation[0, 2] - rotation[2, 0],
            rotation[1, 0] - rotation[0, 1],
        ]
    )
    sine = jnp.sqrt(jnp.sum(twice_sine**2)) / 2
    angle = jnp.arctan2(sine, (jnp.trace(rotation) - 1) / 2)
    return twice_sine / 2 * jnp.where(sine > 0, angle / jnp.where(sine > 0, sine, 1), 1)
