"""The action: a relative move of the pinch point, its yaw and the gripper, each in [-1, 1].

A larger one asks for more, as in OGBench: what is clipped is the pose that it leads to.
"""

import jax
import jax.numpy as jnp

from pigbench.envs import robot, servo, workspace
from pigbench.envs.observation import gripper_opening
from pigbench.envs.physics import PhysicsState
from pigbench.envs.scene import Scene

# What an action of 1 asks for in one control step: metres (x, y, z), radians of yaw, opening.
ACTION_SCALE = (0.05, 0.05, 0.05, 0.3, 1.0)
ACTION_SIZE = len(ACTION_SCALE)


def effector(scene: Scene, state: PhysicsState) -> jax.Array:
    """What an action moves, (5,): pinch position, pinch yaw, gripper opening."""
    rest = jnp.stack([state.pinch_yaw, gripper_opening(scene, state)])
    return jnp.concatenate([state.pinch_pos, rest])


def action_towards(scene: Scene, state: PhysicsState, target: jax.Array) -> jax.Array:
    """The action that asks for the effector's `target` (5,), as far as one step goes."""
    return jnp.clip((target - effector(scene, state)) / jnp.array(ACTION_SCALE), -1.0, 1.0)


def servo_targets(scene: Scene, state: PhysicsState, action: jax.Array) -> jax.Array:
    """The controls (7,) that carry out an action (5,): arm joint angles and gripper control.

    The target is the current pinch pose plus the move, kept inside the workspace.
    """
    target = effector(scene, state) + action * jnp.array(ACTION_SCALE)
    joints = servo.joint_targets(workspace.PINCH.clip(target[:3]), target[3], state.qpos[scene.arm])
    gripper = robot.GRIPPER_CONTROL_MAX * jnp.clip(target[4], 0.0, 1.0)
    return jnp.append(joints, gripper)
