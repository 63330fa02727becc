"""Joint targets of an action, as OGBench's iterative solver finds them: where it stops included.

It makes Newton's steps from the present joints, and stops once it is within a tenth of a
millimetre and of a milliradian. What it leaves undone is part of OGBench's dynamics: with exact
targets the gripper comes out a millimetre elsewhere after 50 control steps.
"""

import jax
import jax.numpy as jnp
import numpy as np

from pigbench.envs import kinematics, robot
from pigbench.envs.rotations import axis_rotation, quat_rotation, rotation_vector

POSITION_TOLERANCE = 1e-4  # metres, of the flange
ANGLE_TOLERANCE = 1e-4  # radians
MAX_TURN = np.radians(45)  # of any joint in one step
MAX_STEPS = 20  # a move of one action takes two or three

_CHAIN = robot.ARM[: 1 + max(i for i, link in enumerate(robot.ARM) if link.joint)]


def joint_targets(pinch_pos: jax.Array, pinch_yaw: jax.Array, joints: jax.Array) -> jax.Array:
    """Where the arm at `joints` (6,) is to go for a pinch pose (3,) and (), gripper down: (6,)."""
    goal_pos, goal_rotation, *_ = flange(kinematics.inverse(pinch_pos, pinch_yaw, joints))

    def error(pose: tuple[jax.Array, ...]) -> tuple[jax.Array, jax.Array]:
        pos, rotation, *_ = pose
        return goal_pos - pos, rotation_vector(goal_rotation @ rotation.T)

    def going_on(carry: tuple[jax.Array, jax.Array]) -> jax.Array:
        steps, joints = carry
        shift, turn = error(flange(joints))
        far = (_length(shift) > POSITION_TOLERANCE) | (_length(turn) > ANGLE_TOLERANCE)
        return far & (steps < MAX_STEPS)

    def step(carry: tuple[jax.Array, jax.Array]) -> tuple[jax.Array, jax.Array]:
        steps, joints = carry
        pose = flange(joints)
        pos, _, axes, anchors = pose
        jacobian = jnp.concatenate([jnp.cross(axes, pos - anchors), axes], axis=-1).T
        update = _solve(jacobian, jnp.concatenate(error(pose)))
        return steps + 1, joints + update * jnp.minimum(1.0, MAX_TURN / jnp.abs(update).max())

    return jax.lax.while_loop(going_on, step, (0, joints))[1]


def flange(joints: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array, jax.Array]:
    """Forward kinematics of joint angles (6,), in the world's frame.

    Returns the flange's position (3,) in metres, the last link's rotation (3, 3), and the axes and
    anchors of the joints, (6, 3) each.
    """
    pos, rotation = jnp.zeros(3), jnp.eye(3)
    axes, anchors = [], []
    for link in _CHAIN:
        pos = pos + rotation @ jnp.array(link.pos, jnp.float32)
        rotation = rotation @ quat_rotation(jnp.array(link.quat, jnp.float32))
        if link.joint:
            axis = jnp.array(link.joint.axis)
            axes.append(rotation @ axis)
            anchors.append(pos)
            rotation = rotation @ axis_rotation(axis, joints[len(axes) - 1])
    tip = pos + rotation @ jnp.array([0.0, robot.FLANGE_OFFSET, 0.0])
    return tip, rotation, jnp.stack(axes), jnp.stack(anchors)


def _length(vector: jax.Array) -> jax.Array:
    return jnp.sqrt(jnp.sum(vector**2))


def _solve(matrix: jax.Array, vector: jax.Array) -> jax.Array:
    """x of matrix x = vector, (n, n) and (n,), by elimination with row pivots.

    Elementwise under `vmap`: the batched solver of jaxlib can hang a small machine.
    """
    size = len(vector)
    system = jnp.concatenate([matrix, vector[:, None]], axis=1)
    free = jnp.ones(size, bool)
    pivots = []
    for column in range(size):
        best = jnp.argmax(jnp.where(free, jnp.abs(system[:, column]), -1.0))
        pivot = jnp.arange(size) == best
        row = jnp.sum(jnp.where(pivot[:, None], system, 0.0), axis=0)
        row = row / row[column]
        system = jnp.where(pivot[:, None], row, system - system[:, column, None] * row)
        free &= ~pivot
        pivots.append(pivot)
    return jnp.stack([jnp.sum(jnp.where(pivot, system[:, -1], 0.0)) for pivot in pivots])
