"""OGBench's Markov oracle, which moves a cube and decides from the current scene alone.

The phases are a table: the first one, from top to bottom, whose condition holds applies.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Bool, Float

from pigbench.envs.oracles.targets import Target
from pigbench.envs.rotations import nearest_symmetry

MAX_STEPS = 200  # control steps after which a sub-task is given up
POSITION_GAIN = 5.0  # action per metre
YAW_GAIN = 3.0  # action per radian
MIN_DISTANCE = 0.4  # metres: nearer destinations are treated as if they were this far away

PLACED = 0.02  # metres within which a cube is at its target
REACHED = 0.02  # metres within which the effector is at a cube
OVER = 0.04  # metres in x and y within which one thing is over another
HOME = 0.04  # metres within which the arm is at its final pose
CARRYING_HEIGHT = 0.16  # metres above which cubes are carried
APPROACH = 0.18  # metres above a cube or target at which the approach starts
LIFT_HEIGHT = 0.36  # metres, the height towards which a gripped cube is lifted
RETREAT_HEIGHT = 0.32  # metres, the height towards which the empty gripper is raised
GRIPPED, LET_GO = 0.5, 0.1  # contact above which a cube is gripped, and below which it is free

OPEN, SHUT = -1.0, 1.0


@struct.dataclass
class OracleInputs:
    """The inputs of the oracle, in metres and radians, and contact in [0, 1]."""

    effector_pos: Float[Array, "3"]
    effector_yaw: Float[Array, ""]
    contact: Float[Array, ""]
    cube_pos: Float[Array, "3"]  # of the cube to be moved
    cube_yaw: Float[Array, ""]


@struct.dataclass
class Pose:
    """The pose to which the arm moves once the cube is at its target."""

    pos: Float[Array, "3"]  # metres
    yaw: Float[Array, ""]  # radians


class Phase(NamedTuple):
    """A phase: its condition, the effector's destination and turn, and the gripper's action."""

    when: Bool[Array, ""]
    destination: Float[Array, "3"]
    turn: Float[Array, ""]
    grip: float


def action(situation: OracleInputs, target: Target, final: Pose) -> Float[Array, "action"]:
    """The action in [-1, 1] that brings the cube towards `target`, then the arm to `final`.

    The gripper always opens or closes at full speed.
    """
    phase = _choose(_phases(situation, target, final))
    way = phase.destination - situation.effector_pos
    distance = jnp.linalg.norm(way)
    way *= jnp.maximum(1.0, MIN_DISTANCE / (distance + 1e-6))
    move = jnp.concatenate(
        [POSITION_GAIN * way, YAW_GAIN * phase.turn[None], jnp.asarray(phase.grip)[None]]
    )
    return jnp.clip(move, -1.0, 1.0)


def done(situation: OracleInputs, target: Target, final: Pose) -> Bool[Array, ""]:
    """Whether the cube is at its target and the arm is at its final pose."""
    return _near(situation.cube_pos, target.pos, PLACED) & _near(
        situation.effector_pos, final.pos, HOME
    )


def _phases(situation: OracleInputs, target: Target, final: Pose) -> tuple[Phase, ...]:
    hand, cube, goal = situation.effector_pos, situation.cube_pos, target.pos
    placed = _near(cube, goal, PLACED)
    over_cube = _near(hand[:2], cube[:2], OVER)
    at_cube = _near(hand, cube, REACHED)
    cube_over_goal = _near(cube[:2], goal[:2], OVER)
    gripped = situation.contact > GRIPPED
    free = situation.contact < LET_GO
    high = hand[2] > CARRYING_HEIGHT

    cube_yaw = nearest_symmetry(situation.cube_yaw, situation.effector_yaw)
    to_cube = cube_yaw - situation.effector_yaw
    to_goal = nearest_symmetry(target.yaw, situation.effector_yaw) - cube_yaw
    to_final = final.yaw - situation.effector_yaw  # not necessarily the shorter way round

    return (
        # The cube is at its target: let go, rise, move away.
        Phase(placed & ~free, goal, to_goal, OPEN),
        Phase(placed & ~high, cube.at[2].set(RETREAT_HEIGHT), to_final, OPEN),
        Phase(placed, final.pos, to_final, OPEN),
        # It is not: move to the cube and grip it.
        Phase(~over_cube, cube.at[2].add(APPROACH), to_cube, OPEN),
        Phase(~at_cube, cube, to_cube, OPEN),
        Phase(~gripped, cube, to_cube, SHUT),
        # The cube is in the gripper: lift it, carry it, lower it.
        Phase(~cube_over_goal & ~high, cube.at[2].set(LIFT_HEIGHT), to_goal, SHUT),
        Phase(~cube_over_goal, goal.at[2].add(APPROACH), to_goal, SHUT),
        Phase(jnp.ones_like(placed), goal, to_goal, SHUT),
    )


def _choose(phases: tuple[Phase, ...]) -> Phase:
    """The first phase that applies; the last one always does."""
    conditions = [phase.when for phase in phases]
    return jax.tree.map(lambda *choices: jnp.select(conditions, choices), *phases)


def _near(
    one: Float[Array, "axis"], other: Float[Array, "axis"], distance: float
) -> Bool[Array, ""]:
    return jnp.linalg.norm(one - other) <= distance
