"""The action: a relative move of the pinch point, its yaw and the gripper, each in [-1, 1].

As in OGBench, actions are not clipped, so larger values move further; the target pose is clipped.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from pigbench.envs import robot, servo, workspace
from pigbench.envs.observation import gripper_opening
from pigbench.envs.physics import PhysicsState
from pigbench.envs.scene import Scene
from pigbench.envs.units import ACTION_SCALE


def effector(scene: Scene, state: PhysicsState) -> Float[Array, "action"]:
    """The quantities that an action moves: pinch position, pinch yaw, gripper opening."""
    rest = jnp.stack([state.pinch_yaw, gripper_opening(scene, state)])
    return jnp.concatenate([state.pinch_pos, rest])


def action_towards(
    scene: Scene, state: PhysicsState, target: Float[Array, "action"]
) -> Float[Array, "action"]:
    """The action that moves the effector towards `target`, as far as one step goes."""
    return jnp.clip((target - effector(scene, state)) / jnp.array(ACTION_SCALE), -1.0, 1.0)


def servo_targets(
    scene: Scene, state: PhysicsState, action: Float[Array, "action"]
) -> Float[Array, "nu"]:
    """The controls that execute an action: arm joint angles and gripper control.

    The target is the current pinch pose plus the move, clipped to the workspace.
    """
    target = effector(scene, state) + action * jnp.array(ACTION_SCALE)
    joints = servo.joint_targets(workspace.PINCH.clip(target[:3]), target[3], state.qpos[scene.arm])
    gripper = robot.GRIPPER_CONTROL_MAX * jnp.clip(target[4], 0.0, 1.0)
    return jnp.append(joints, gripper)
