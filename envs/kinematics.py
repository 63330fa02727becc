"""Closed-form inverse kinematics of the UR5e with the gripper pointing straight down.

With the tool vertical, the axes of shoulder lift, elbow and wrist 1 are parallel and the second
wrist joint is at -pi/2, so the arm is a planar two-link chain on a turntable. The solution is on
the branch of the home pose (elbow up, shoulder to the right), which the arm never leaves inside the
workspace.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from pigbench.envs import robot
from pigbench.envs.rotations import nearest_turn

LATERAL_OFFSET = robot.SHOULDER_OFFSET + robot.ELBOW_OFFSET + robot.WRIST_1_OFFSET
TOOL_LENGTH = robot.FLANGE_OFFSET + robot.GRIPPER_MOUNT + robot.GRIPPER_BASE + robot.PINCH_HEIGHT


def inverse(
    pinch_pos: Float[Array, "*batch 3"],
    pinch_yaw: Float[Array, "*batch"],
    near: Float[Array, "*batch joint"],
) -> Float[Array, "*batch joint"]:
    """Joint angles that bring the pinch point to a pose, with the gripper pointing down.

    Args:
        pinch_pos: metres, in the world frame.
        pinch_yaw: radians.
        near: joint angles. Among solutions that differ by whole turns, the joints turn
            least from these, and for the last joint it is the tool that turns least.

    Returns:
        Joint angles. If the point is out of reach, the arm is stretched towards it.
    """
    x, y, z = jnp.moveaxis(pinch_pos, -1, 0)
    # The base is rotated by a quarter turn about z: its x axis is the world's y axis.
    base_x, base_y = y, -x
    reach = jnp.sqrt(jnp.maximum(base_x**2 + base_y**2 - LATERAL_OFFSET**2, 0.0))
    shoulder_pan = jnp.arctan2(base_y, base_x) - jnp.arctan2(LATERAL_OFFSET, reach)

    along = reach - robot.WRIST_2_OFFSET
    down = robot.SHOULDER_HEIGHT - TOOL_LENGTH - z
    upper, fore = robot.UPPER_ARM, robot.FOREARM
    cos_elbow = (along**2 + down**2 - upper**2 - fore**2) / (2 * upper * fore)
    elbow = jnp.arccos(jnp.clip(cos_elbow, -1.0, 1.0))
    shoulder_lift = jnp.arctan2(down, along) - jnp.arctan2(
        fore * jnp.sin(elbow), upper + fore * jnp.cos(elbow)
    )
    wrist_1 = -jnp.pi / 2 - shoulder_lift - elbow
    wrist_2 = jnp.full_like(elbow, -jnp.pi / 2)
    wrist_3 = shoulder_pan + jnp.pi / 2 - pinch_yaw
    joints = jnp.stack([shoulder_pan, shoulder_lift, elbow, wrist_1, wrist_2, wrist_3], axis=-1)
    # The angle of the last joint at which the tool would keep its yaw.
    steady = near[..., 5] + nearest_turn(shoulder_pan, near[..., 0]) - near[..., 0]
    return nearest_turn(joints, jnp.append(near[..., :5], steady[..., None], axis=-1))
