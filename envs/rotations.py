"""Angles and quaternions (w, x, y, z); elementwise, so that any leading dimensions do."""

import jax
import jax.numpy as jnp


def wrap(angle: jax.Array) -> jax.Array:
    """The same angle in [-pi, pi)."""
    return jnp.mod(angle + jnp.pi, 2 * jnp.pi) - jnp.pi


def nearest_turn(angle: jax.Array, reference: jax.Array) -> jax.Array:
    """The same angle, by whole turns nearest to `reference`."""
    return reference + wrap(angle - reference)


def yaw_quat(yaw: jax.Array) -> jax.Array:
    """The quaternion (..., 4) of a rotation by `yaw` (...) about z."""
    zero = jnp.zeros_like(yaw)
    return jnp.stack([jnp.cos(yaw / 2), zero, zero, jnp.sin(yaw / 2)], axis=-1)


def quat_yaw(quat: jax.Array) -> jax.Array:
    """The yaw (...) of a quaternion (..., 4), of the roll-pitch-yaw angles."""
    w, x, y, z = jnp.moveaxis(quat, -1, 0)
    return jnp.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def nearest_symmetry(yaw: jax.Array, reference: jax.Array, fold: int = 4) -> jax.Array:
    """The yaw equal to `yaw` up to the `fold`-fold symmetry of a cube, nearest to `reference`."""
    step = 2 * jnp.pi / fold
    return yaw + step * jnp.round((reference - yaw) / step)
