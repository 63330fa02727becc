"""How to move a cube: what the scene shows decides, as OGBench's Markov oracle has it.

The phases are a table, from top to bottom: the first whose condition holds decides.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from flax import struct

from pigbench.envs.oracles.targets import Target
from pigbench.envs.rotations import nearest_symmetry

MAX_STEPS = 200  # control steps after which a sub-task is given up
POSITION_GAIN = 5.0  # action per metre
YAW_GAIN = 3.0  # action per radian
MIN_DISTANCE = 0.4  # metres: whatever is nearer is moved to as if it was this far

REACHED = 0.02  # metres within which a cube, or its target, is reached
OVER = 0.04  # metres in x and y within which one thing is over another
HOME = 0.04  # metres within which the arm is at its final pose
CARRYING_HEIGHT = 0.16  # metres above which cubes are carried
APPROACH = 0.18  # metres above a cube or target from where it is approached
LIFT_HEIGHT = 0.36  # metres that a gripped cube is lifted towards
RETREAT_HEIGHT = 0.32  # metres that the empty gripper is raised towards
GRIPPED, LET_GO = 0.5, 0.1  # contact above which a cube is gripped, and below which it is free

OPEN, SHUT = -1.0, 1.0


@struct.dataclass
class Situation:
    """What the oracle looks at: metres, radians, and contact in [0, 1]."""

    effector_pos: jax.Array  # (3,)
    effector_yaw: jax.Array  # ()
    contact: jax.Array  # ()
    cube_pos: jax.Array  # (3,) of the cube to be moved
    cube_yaw: jax.Array  # ()


@struct.dataclass
class Pose:
    """Where the arm goes once the cube is at its target."""

    pos: jax.Array  # (3,) metres
    yaw: jax.Array  # () radians


class Phase(NamedTuple):
    """A phase: when it applies, where the effector goes, how far it turns, what the fingers do."""

    when: jax.Array
    destination: jax.Array
    turn: jax.Array
    grip: float


def action(situation: Situation, target: Target, final: Pose) -> jax.Array:
    """The action (5,) in [-1, 1] that brings the cube nearer to `target`, then the arm to `final`.

    The gripper's opening is changed at full speed in one direction or the other.
    """
    phase = _choose(_phases(situation, target, final))
    way = phase.destination - situation.effector_pos
    distance = jnp.linalg.norm(way)
    way *= jnp.maximum(1.0, MIN_DISTANCE / (distance + 1e-6))
    move = jnp.concatenate(
        [POSITION_GAIN * way, YAW_GAIN * phase.turn[None], jnp.asarray(phase.grip)[None]]
    )
    return jnp.clip(move, -1.0, 1.0)


def done(situation: Situation, target: Target, final: Pose) -> jax.Array:
    """Whether the cube is at its target and the arm at its final pose, () bool."""
    return _near(situation.cube_pos, target.pos, REACHED) & _near(
        situation.effector_pos, final.pos, HOME
    )


def _phases(situation: Situation, target: Target, final: Pose) -> tuple[Phase, ...]:
    hand, cube, goal = situation.effector_pos, situation.cube_pos, target.pos
    placed = _near(cube, goal, REACHED)
    over_cube = _near(hand[:2], cube[:2], OVER)
    at_cube = _near(hand, cube, REACHED)
    cube_over_goal = _near(cube[:2], goal[:2], OVER)
    gripped = situation.contact > GRIPPED
    free = situation.contact < LET_GO
    high = hand[2] > CARRYING_HEIGHT

    cube_yaw = nearest_symmetry(situation.cube_yaw, situation.effector_yaw)
    to_cube = cube_yaw - situation.effector_yaw
    to_goal = nearest_symmetry(target.yaw, situation.effector_yaw) - cube_yaw
    to_final = final.yaw - situation.effector_yaw  # not the shorter way round

    return (
        # The cube is at its target: let go, rise, leave.
        Phase(placed & ~free, goal, to_goal, OPEN),
        Phase(placed & ~high, cube.at[2].set(RETREAT_HEIGHT), to_final, OPEN),
        Phase(placed, final.pos, to_final, OPEN),
        # It is not: go there, grip it.
        Phase(~over_cube, cube.at[2].add(APPROACH), to_cube, OPEN),
        Phase(~at_cube, cube, to_cube, OPEN),
        Phase(~gripped, cube, to_cube, SHUT),
        # It is in the gripper: lift it, carry it, lower it.
        Phase(~cube_over_goal & ~high, cube.at[2].set(LIFT_HEIGHT), to_goal, SHUT),
        Phase(~cube_over_goal, goal.at[2].add(APPROACH), to_goal, SHUT),
        Phase(jnp.ones_like(placed), goal, to_goal, SHUT),
    )


def _choose(phases: tuple[Phase, ...]) -> Phase:
    """The first phase that applies; the last one always does."""
    conditions = [phase.when for phase in phases]
    return jax.tree.map(lambda *choices: jnp.select(conditions, choices), *phases)


def _near(one: jax.Array, other: jax.Array, distance: float) -> jax.Array:
    return jnp.linalg.norm(one - other) <= distance
