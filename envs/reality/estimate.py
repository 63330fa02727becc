"""A camera's estimates of the cubes' poses.

A frame is taken at every control step. Each cube's true pose is disturbed by an episode's
calibration error and a frame's noise. If the cube is not found in a frame, the previous estimate
stays; estimates are known only after a latency of some control steps.
"""

from dataclasses import replace

import jax
import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Float, PRNGKeyArray

from pigbench.envs.observation import cube_poses
from pigbench.envs.physics import PhysicsState
from pigbench.envs.reality import PoseEstimate, delay
from pigbench.envs.rotations import quat_product, yaw_quat
from pigbench.envs.scene import Scene


@struct.dataclass
class Track:
    """The estimates of the cubes' poses, each a position 3 and a quaternion 4."""

    bias: Float[Array, "cube 4"]  # metres and radians of yaw, fixed for the episode
    line: Float[Array, "latency cube 7"]  # estimates that are not known yet
    newest: Float[Array, "cube 7"]  # the latest estimate made
    known: Float[Array, "cube 7"]  # the latest estimate known


def begin(key: PRNGKeyArray, model: PoseEstimate, scene: Scene, physics: PhysicsState) -> Track:
    """The first estimate of an episode, known at once because the scene is at rest."""
    bias_key, wrong_key, noise_key = jax.random.split(key, 3)
    wrong = jax.random.uniform(wrong_key, (scene.num_cubes, 1)) < model.misregistration
    usual = jnp.array([*[model.position_bias] * 3, model.yaw_bias])
    scale = jnp.where(wrong, usual.at[:3].set(model.misregistration_bias), usual)
    bias = scale * jax.random.normal(bias_key, scale.shape)
    first = _measure(noise_key, model, bias, _poses(scene, physics))
    return Track(bias=bias, line=delay.begin(first, model.latency), newest=first, known=first)


def advance(
    key: PRNGKeyArray, model: PoseEstimate, scene: Scene, track: Track, physics: PhysicsState
) -> Track:
    """The estimates one control step later, with a new frame of the scene."""
    noise_key, loss_key = jax.random.split(key)
    poses = _poses(scene, physics)
    distance = jnp.linalg.norm(poses[:, :3] - physics.pinch_pos, axis=-1)
    covered = distance < model.occlusion_distance
    loss = jnp.where(covered, jnp.maximum(model.occluded_dropout, model.dropout), model.dropout)
    lost = jax.random.uniform(loss_key, loss.shape) < loss
    measured = _measure(noise_key, model, track.bias, poses)
    newest = jnp.where(lost[:, None], track.newest, measured)
    line, known = delay.push(track.line, newest)
    return replace(track, line=line, newest=newest, known=known)


def _measure(
    key: PRNGKeyArray,
    model: PoseEstimate,
    bias: Float[Array, "cube 4"],
    poses: Float[Array, "cube 7"],
) -> Float[Array, "cube 7"]:
    """The estimate of `poses` from one frame."""
    scale = jnp.array([*[model.position_noise] * 3, model.yaw_noise])
    error = bias + scale * jax.random.normal(key, bias.shape)
    turned = quat_product(yaw_quat(error[:, 3]), poses[:, 3:])
    return jnp.concatenate([poses[:, :3] + error[:, :3], turned], axis=-1)


def _poses(scene: Scene, physics: PhysicsState) -> Float[Array, "cube 7"]:
    return jnp.concatenate(cube_poses(scene, physics), axis=-1)
