"""Where a camera says that the cubes are.

A frame is taken at every control step. An episode's error of calibration and a frame's noise are
added to each cube's true pose; a frame in which the cube is not found leaves the estimate before
it; and what the camera sees is known some control steps later.
"""

from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
from flax import struct

from pigbench.envs.observation import cube_poses
from pigbench.envs.physics import PhysicsState
from pigbench.envs.reality import delay
from pigbench.envs.rotations import quat_product, yaw_quat
from pigbench.envs.scene import Scene


@dataclass(frozen=True)
class PoseEstimate:
    """How a pose's estimate differs from the pose; where all is 0, it does not.

    Attributes:
        position_noise: metres, standard deviation of each coordinate in every frame.
        yaw_noise: radians, likewise.
        position_bias: metres, standard deviation of each coordinate's error that lasts an episode.
        yaw_bias: radians, likewise.
        misregistration: the probability that an episode's track of a cube begins at a wrong pose.
        misregistration_bias: metres, by which it is off then, as `position_bias`.
        dropout: the probability that a frame is lost.
        occlusion_distance: metres from the pinch point to a cube that the gripper covers.
        occluded_dropout: the probability that a frame of a covered cube is lost.
        latency: control steps from a frame to its estimate.
    """

    position_noise: float = 0.0
    yaw_noise: float = 0.0
    position_bias: float = 0.0
    yaw_bias: float = 0.0
    misregistration: float = 0.0
    misregistration_bias: float = 0.0
    dropout: float = 0.0
    occlusion_distance: float = 0.0
    occluded_dropout: float = 0.0
    latency: int = 0


@struct.dataclass
class Track:
    """What is known of the cubes' poses, each a position 3 and a quaternion 4.

    Attributes:
        bias: (num_cubes, 4) metres and radians of yaw, an episode's.
        line: (latency, num_cubes, 7), estimates that are not known yet.
        newest: (num_cubes, 7), the last to be made.
        known: (num_cubes, 7), the last to be known.
    """

    bias: jax.Array
    line: jax.Array
    newest: jax.Array
    known: jax.Array


def begin(key: jax.Array, model: PoseEstimate, scene: Scene, physics: PhysicsState) -> Track:
    """An episode's first estimate, of a scene at rest: there was time to see it."""
    bias_key, wrong_key, noise_key = jax.random.split(key, 3)
    wrong = jax.random.uniform(wrong_key, (scene.num_cubes, 1)) < model.misregistration
    usual = jnp.array([*[model.position_bias] * 3, model.yaw_bias])
    scale = jnp.where(wrong, usual.at[:3].set(model.misregistration_bias), usual)
    bias = scale * jax.random.normal(bias_key, scale.shape)
    first = _measure(noise_key, model, bias, _poses(scene, physics))
    return Track(bias=bias, line=delay.begin(first, model.latency), newest=first, known=first)


def advance(
    key: jax.Array, model: PoseEstimate, scene: Scene, track: Track, physics: PhysicsState
) -> Track:
    """What is known a control step later, with a frame of the scene as it is then."""
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


def _measure(key: jax.Array, model: PoseEstimate, bias: jax.Array, poses: jax.Array) -> jax.Array:
    """A frame's estimate of poses (num_cubes, 7)."""
    scale = jnp.array([*[model.position_noise] * 3, model.yaw_noise])
    error = bias + scale * jax.random.normal(key, bias.shape)
    turned = quat_product(yaw_quat(error[:, 3]), poses[:, 3:])
    return jnp.concatenate([poses[:, :3] + error[:, :3], turned], axis=-1)


def _poses(scene: Scene, physics: PhysicsState) -> jax.Array:
    return jnp.concatenate(cube_poses(scene, physics), axis=-1)
