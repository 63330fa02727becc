"""The joint targets of an action, as OGBench's iterative solver finds them, early stop included.

The solver takes Newton steps from the current joints and stops within a tenth of a millimetre and
a tenth of a milliradian. The remaining error is part of OGBench's dynamics: with exact targets, the
gripper is off by a millimetre after 50 control steps.
"""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from pigbench.envs import kinematics, robot
from pigbench.envs.rotations import axis_rotation, quat_rotation, rotation_vector

POSITION_TOLERANCE = 1e-4  # metres, of the flange
ANGLE_TOLERANCE = 1e-4  # radians
MAX_TURN = np.radians(45)  # of any joint in one step
MAX_STEPS = 20  # the move of one action takes two or three

Carry = tuple[Int[Array, ""], Float[Array, "joint"], Bool[Array, ""]]
"""Steps done, joint angles, and whether they are still too far."""

_System = tuple[Float[Array, "n n+1"], Int[Array, "n"]]
"""Rows of a linear system, its right side in the last column, and each column's pivot row."""

_CHAIN = robot.ARM[: 1 + max(i for i, link in enumerate(robot.ARM) if link.joint)]


@jax.jit  # traced once, because a control step has it wherever it is compiled
def joint_targets(
    pinch_pos: Float[Array, "3"], pinch_yaw: Float[Array, ""], joints: Float[Array, "joint"]
) -> Float[Array, "joint"]:
    """Joint targets for a pinch pose with the gripper down, from the current `joints`."""
    goal_pos, goal_rotation, *_ = flange(kinematics.inverse(pinch_pos, pinch_yaw, joints))

    def going_on(carry: Carry) -> Bool[Array, ""]:
        steps, _, far = carry
        return far & (steps < MAX_STEPS)

    def step(carry: Carry) -> Carry:
        steps, joints, _ = carry
        pos, rotation, axes, anchors = flange(joints)
        shift, turn = goal_pos - pos, rotation_vector(goal_rotation @ rotation.T)
        far = (_length(shift) > POSITION_TOLERANCE) | (_length(turn) > ANGLE_TOLERANCE)
        jacobian = jnp.concatenate([jnp.cross(axes, pos - anchors), axes], axis=-1).T
        update = _solve(jacobian, jnp.concatenate([shift, turn]))
        update *= jnp.minimum(1.0, MAX_TURN / jnp.abs(update).max())
        return steps + 1, jnp.where(far, joints + update, joints), far

    return jax.lax.while_loop(going_on, step, (jnp.asarray(0), joints, jnp.asarray(True)))[1]


def flange(
    joints: Float[Array, "joint"],
) -> tuple[
    Float[Array, "3"], Float[Array, "3 3"], Float[Array, "joint 3"], Float[Array, "joint 3"]
]:
    """Forward kinematics of joint angles, in the world frame.

    Returns the flange's position in metres, the last link's rotation, and the joints' axes and
    anchors.
    """
    pos, rotation = jnp.zeros(3), jnp.eye(3)
    axes, anchors = [], []
    for link in _CHAIN:
        pos = pos + rotation @ np.array(link.pos, np.float32)
        rotation = rotation @ quat_rotation(link.quat)
        if link.joint:
            axes.append(rotation @ np.array(link.joint.axis, np.float32))
            anchors.append(pos)
            rotation = rotation @ axis_rotation(link.joint.axis, joints[len(axes) - 1])
    tip = pos + rotation @ jnp.array([0.0, robot.FLANGE_OFFSET, 0.0])
    return tip, rotation, jnp.stack(axes), jnp.stack(anchors)


def pinch(joints: Float[Array, "joint"]) -> tuple[Float[Array, "3"], Float[Array, ""]]:
    """The pinch point, in metres, and its yaw, in radians, for joint angles."""
    tip, rotation, *_ = flange(joints)
    to_pinch = robot.GRIPPER_MOUNT + robot.GRIPPER_BASE + robot.PINCH_HEIGHT
    mount, base = (quat_rotation(link.quat) for link in robot.ARM[-2:])
    turned = rotation @ mount @ base
    pos = tip + rotation @ jnp.array([0.0, to_pinch, 0.0])
    return pos, jnp.arctan2(turned[1, 0], turned[0, 0])


def _length(vector: Float[Array, "n"]) -> Float[Array, ""]:
    return jnp.sqrt(jnp.sum(vector**2))


def _solve(matrix: Float[Array, "n n"], vector: Float[Array, "n"]) -> Float[Array, "n"]:
    """The solution x of matrix x = vector, by elimination with row pivots.

    It is elementwise under `vmap`; jaxlib's batched solver can hang on a small machine.
    """
    size = len(vector)
    rows = jnp.arange(size)

    def eliminate(column: Int[Array, ""], carry: _System) -> _System:
        system, order = carry
        used = jnp.any(order[:, None] == rows, axis=0)
        pivot = jnp.argmax(jnp.where(used, -1.0, jnp.abs(system[:, column])))
        row = system[pivot] / system[pivot, column]
        rest = system - system[:, column, None] * row
        return jnp.where((rows == pivot)[:, None], row, rest), order.at[column].set(pivot)

    system = jnp.concatenate([matrix, vector[:, None]], axis=1)
    order = jnp.full(size, size)
    system, order = jax.lax.fori_loop(0, size, eliminate, (system, order))
    return system[order, -1]
