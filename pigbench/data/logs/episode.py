"""A log's episode, resampled to control steps, in the simulation's frame, with its actions.

Between two rows, states are interpolated linearly, quaternions along the shorter arc; commands and
actions hold until the next row.
"""

from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.spatial.transform import Rotation

from pigbench import envs
from pigbench.data.logs.columns import TARGETS, LogGroups, LogTable, groups
from pigbench.envs import robot, servo
from pigbench.envs.physics import PhysicsState
from pigbench.envs.units import ACTION_SCALE, CONTROL_STEP, PAD_FORCE_SCALE
from pigbench.errors import UserError

BASE_YAW = -np.pi / 2
"""Rotation of the controller's base frame about the world's z axis: its x is the world's -y."""

GAP = 0.15
"""Seconds between two rows beyond which they form a gap, which is bridged and reported."""
LONGEST_GAP = 1.0
"""Seconds beyond which a gap is an error, since nobody knows what happened."""
SLOWEST, FASTEST = 0.2, 0.0005
"""Bounds of the median seconds between rows."""
JUMP = 0.05
"""Metres between two control steps beyond which a cube's estimated position must be wrong."""
FASTEST_JOINT = 3.5
"""rad/s that no joint of a UR5e exceeds: its limit is 3.14."""
FARTHEST_TARGET = 0.25
"""Bound of the median distance in metres from the gripper to its commanded pose in one frame."""
REACH = 1.1
"""Metres from the robot's foot within which it can reach an object."""
STILL = 0.02
"""Standard deviation in rad/s below which a robot hardly moves, so that velocities tell nothing."""
LARGEST_RATIO = 3.0
"""Bound of the ratio of recorded velocities to those computed from positions, either way."""
LEAST_CORRELATION = 0.3
"""Least correlation of recorded velocities with those computed from positions."""
RATE_TOLERANCE = 0.1
"""Share of a control step by which the median time between rows may differ from one."""
CLOCK_TOLERANCE = 0.1
"""Share of a control step by which clocks may differ."""
LENGTH_TOLERANCE = 0.05
"""How far the length of a quaternion may be from 1."""
STOPPED = 0.01
"""Change of the opening in a control step below which the fingers stand still."""
NEARLY_OPEN, NEARLY_SHUT = 0.1, 0.95
"""Openings between which fingers that stand still must have met something."""

_BLOCK = 512  # rows
_forward = jax.jit(jax.vmap(servo.pinch))


@dataclass(frozen=True)
class LoggedEpisode:
    """A log's episode at control steps, in the world's frame; `notes` lists its irregularities."""

    name: str
    joint_pos: Float[np.ndarray, "time 6"]  # rad
    joint_vel: Float[np.ndarray, "time 6"]  # rad/s
    opening: Float[np.ndarray, "time"]  # 0 open to 1 shut
    contact: Float[np.ndarray, "time"]  # 0 to 1
    object_pos: Float[np.ndarray, "time 3"]  # m
    object_quat: Float[np.ndarray, "time 4"]
    actions: Float[np.ndarray, "time 5"]
    notes: tuple[str, ...]


def prepare(name: str, table: LogTable) -> LoggedEpisode:
    """Turn a table into an episode. Raises UserError for data that no robot can have produced."""
    found = groups(name, table)
    time = found["time"][:, 0]
    _check_clock(name, time)
    grid = time[0] + CONTROL_STEP * np.arange(int((time[-1] - time[0]) / CONTROL_STEP + 1e-6) + 1)
    if len(grid) < 2:
        raise UserError(
            f"{name} is {time[-1] - time[0]:.2f} s long: it must have at least two control steps"
        )
    linear, holding = partial(_linear, time, grid), partial(_holding, time, grid)
    joint_pos = linear(_near_home(found["joint_pos"]))
    velocity = np.gradient(joint_pos, CONTROL_STEP, axis=0)
    joint_vel = linear(found["joint_vel"]) if "joint_vel" in found else velocity
    _check_velocities(name, joint_vel, velocity)
    opening = np.clip(linear(found["gripper_opening"])[:, 0], 0.0, 1.0)
    known = "gripper_contact" in found
    contact = linear(found["gripper_contact"])[:, 0] if known else _stands_between(opening)
    pos = _to_world(linear(found["object_pos"]))
    if np.linalg.norm(pos[:, :2], axis=-1).min() > REACH:
        raise UserError(f"{name}: the object is never within {REACH} m of the robot's base")
    quat = _turned(linear(_same_sign(name, found["object_quat"])))
    if set(TARGETS) <= found.keys():
        targets = {key: holding(found[key]) for key in TARGETS}
        actions = _recovered(name, joint_pos, opening, targets)
    else:
        actions = holding(found["action"])
        _check_rate(name, time)
    return LoggedEpisode(
        name=name,
        joint_pos=joint_pos,
        joint_vel=joint_vel,
        opening=opening,
        contact=np.clip(contact, 0.0, 1.0),
        object_pos=pos,
        object_quat=quat,
        actions=np.clip(actions, -1.0, 1.0),
        notes=(*_gaps(time), *_outliers(velocity, pos), *_clipped(actions)),
    )


def observe(
    env: "envs.CubeEnv", episodes: list[LoggedEpisode]
) -> Float[np.ndarray, "row observation"]:
    """The environment's observations of all steps, one episode after another."""

    def joined(field: str) -> Float[Array, "row ..."]:
        return jnp.asarray(np.concatenate([getattr(one, field) for one in episodes]), jnp.float32)

    model, scene = env.scene.model, env.scene
    home, still = jnp.asarray(scene.home_qpos, jnp.float32), jnp.zeros(model.nv)

    def observe(
        joint_pos, joint_vel, opening, contact, object_pos, object_quat
    ) -> Float[Array, "observation"]:
        pose = jnp.concatenate([object_pos, object_quat])
        qpos = home.at[scene.arm].set(joint_pos).at[scene.cubes_qpos].set(pose)
        pinch_pos, pinch_yaw = servo.pinch(joint_pos)
        seen = PhysicsState(
            qpos=qpos.at[scene.driver].set(robot.GRIPPER_CLOSED * opening),
            qvel=still.at[scene.arm].set(joint_vel),
            warmstart=still,
            pinch_pos=pinch_pos,
            pinch_yaw=pinch_yaw,
            pad_force=contact / PAD_FORCE_SCALE,
            diverged=jnp.zeros((), bool),
            overflow=jnp.zeros((), bool),
        )
        return env.observe(seen)

    names = ("joint_pos", "joint_vel", "opening", "contact", "object_pos", "object_quat")
    return np.asarray(jax.jit(jax.vmap(observe))(*map(joined, names)))


def _check_clock(name: str, time: Float[np.ndarray, "row"]) -> None:
    if len(time) < 2:
        raise UserError(f"{name} has {len(time)} rows: it must have at least two")
    steps = np.diff(time)
    if (steps <= 0).any():
        row = int((steps <= 0).argmax()) + 1
        how = "stands still" if steps[row - 1] == 0 else f"goes back by {-steps[row - 1]:g} s"
        raise UserError(f"{name}: time {how} in row {row}")
    usual = float(np.median(steps))
    if usual > SLOWEST:
        raise UserError(f"{name}: rows are {usual:g} s apart: time must be in seconds, is it not?")
    if usual < FASTEST:
        raise UserError(f"{name}: rows are {usual:g} s apart, more often than any robot logs")
    if steps.max() > LONGEST_GAP:
        row = int(steps.argmax()) + 1
        raise UserError(
            f"{name}: time jumps by {steps.max():g} s in row {row}: a gap, or two clocks"
        )


def _check_velocities(
    name: str, joint_vel: Float[np.ndarray, "time 6"], velocity: Float[np.ndarray, "time 6"]
) -> None:
    """Raise UserError unless joint_vel matches the changes of joint_pos.

    Otherwise a unit is wrong, or the two come from different clocks.
    """
    moved, said = np.std(velocity), np.std(joint_vel)
    if moved < STILL and said < STILL:
        return
    ratio = said / max(moved, 1e-9)
    if not 1 / LARGEST_RATIO < ratio < LARGEST_RATIO:
        raise UserError(
            f"{name}: joint_vel is {ratio:.2g} times what joint_pos changes by: a wrong unit, of "
            "either or of time"
        )
    if np.mean(joint_vel * velocity) < LEAST_CORRELATION * moved * said:
        raise UserError(
            f"{name}: joint_vel is not what joint_pos changes by: are they of two clocks?"
        )


def _check_rate(name: str, time: Float[np.ndarray, "row"]) -> None:
    usual = float(np.median(np.diff(time)))
    if not np.isclose(usual, CONTROL_STEP, rtol=RATE_TOLERANCE):
        raise UserError(
            f"{name}: actions are moves of {CONTROL_STEP} s, and rows are {usual:g} s apart: tell "
            "commanded poses (target_x ...) instead"
        )


def _recovered(
    name: str,
    joint_pos: Float[np.ndarray, "row 6"],
    opening: Float[np.ndarray, "row"],
    targets: LogGroups,
) -> Float[np.ndarray, "row 5"]:
    """The actions that lead from the gripper's poses to the commanded ones."""
    here, yaw = _pinch(joint_pos)
    way = _to_world(targets["target_pos"]) - here
    far = float(np.median(np.linalg.norm(way, axis=-1)))
    if far > FARTHEST_TARGET:
        raise UserError(
            f"{name}: what is commanded is {far:.2f} m from the gripper (median): both must be in "
            "the robot's base frame"
        )
    turn = targets["target_yaw"][:, 0] + BASE_YAW - yaw
    turn -= 2 * np.pi * np.round(turn / (2 * np.pi))
    grip = targets["target_opening"][:, 0] - opening
    return np.column_stack([way, turn, grip]) / np.array(ACTION_SCALE)


def _pinch(
    joint_pos: Float[np.ndarray, "row 6"],
) -> tuple[Float[np.ndarray, "row 3"], Float[np.ndarray, "row"]]:
    """Pinch points in metres and yaws in radians."""
    rows = len(joint_pos)
    # Padded to whole blocks, so that not every length is compiled anew.
    padded = np.pad(np.float32(joint_pos), ((0, -rows % _BLOCK), (0, 0)), mode="edge")
    pos, yaw = _forward(padded)
    return np.asarray(pos)[:rows], np.asarray(yaw)[:rows]


def _near_home(joint_pos: Float[np.ndarray, "row 6"]) -> Float[np.ndarray, "row 6"]:
    """The same angles, unwrapped and shifted by whole turns to begin near home."""
    angles = np.unwrap(joint_pos, axis=0)
    return angles - 2 * np.pi * np.round((angles[0] - np.array(robot.HOME)) / (2 * np.pi))


def _stands_between(opening: Float[np.ndarray, "time"]) -> Float[np.ndarray, "time"]:
    """Contact, inferred from fingers stopped on their way: neither moving, nor open, nor shut."""
    still = np.abs(np.gradient(opening)) < STOPPED
    return (still & (opening > NEARLY_OPEN) & (opening < NEARLY_SHUT)).astype(float)


def _linear(
    time: Float[np.ndarray, "row"],
    grid: Float[np.ndarray, "time"],
    values: Float[np.ndarray, "row n"],
) -> Float[np.ndarray, "time n"]:
    return np.column_stack([np.interp(grid, time, column) for column in values.T])


def _holding(
    time: Float[np.ndarray, "row"],
    grid: Float[np.ndarray, "time"],
    values: Float[np.ndarray, "row n"],
) -> Float[np.ndarray, "time n"]:
    """The last value at or before each time of the grid, give or take `CLOCK_TOLERANCE`."""
    rows = np.searchsorted(time, grid + CLOCK_TOLERANCE * CONTROL_STEP, side="right") - 1
    return values[np.maximum(rows, 0)]


def _to_world(pos: Float[np.ndarray, "time 3"]) -> Float[np.ndarray, "time 3"]:
    """Positions, converted from the base frame to the world's."""
    cos, sin = np.cos(BASE_YAW), np.sin(BASE_YAW)
    return pos @ np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]).T


def _same_sign(name: str, quats: Float[np.ndarray, "row 4"]) -> Float[np.ndarray, "row 4"]:
    """The same rotations, each with the sign that is nearer to the quaternion before."""
    length = np.linalg.norm(quats, axis=-1)
    if np.abs(length - 1).max() > LENGTH_TOLERANCE:
        row = int(np.abs(length - 1).argmax())
        raise UserError(
            f"{name}: the object's quaternion has length {length[row]:.2f} in row {row}, not 1"
        )
    signs = np.where(np.sum(quats[1:] * quats[:-1], axis=-1) < 0, -1.0, 1.0)
    return quats * np.cumprod([1.0, *signs])[:, None]


def _turned(quats: Float[np.ndarray, "time 4"]) -> Float[np.ndarray, "time 4"]:
    """Quaternions, converted from the base frame to the world's and normalised."""
    turned = Rotation.from_euler("z", BASE_YAW) * Rotation.from_quat(quats, scalar_first=True)
    return turned.as_quat(scalar_first=True)


def _gaps(time: Float[np.ndarray, "row"]) -> list[str]:
    steps = np.diff(time)
    return [
        f"a gap of {steps[row]:.2f} s at {time[row] - time[0]:.2f} s is bridged"
        for row in np.flatnonzero(steps > GAP)
    ]


def _outliers(velocity: Float[np.ndarray, "time 6"], pos: Float[np.ndarray, "time 3"]) -> list[str]:
    fast = np.abs(velocity).max(axis=-1) > FASTEST_JOINT
    jumps = np.linalg.norm(np.diff(pos, axis=0), axis=-1) > JUMP
    found = {
        f"a joint is faster than {FASTEST_JOINT} rad/s": fast,
        f"the object moves by more than {100 * JUMP:g} cm": jumps,
    }
    return [
        f"{what} in {outlying.sum()} steps, first at {CONTROL_STEP * outlying.argmax():.2f} s"
        for what, outlying in found.items()
        if outlying.any()
    ]


def _clipped(actions: Float[np.ndarray, "time 5"]) -> list[str]:
    beyond = np.abs(actions[:, :4]).max(axis=-1) > 1
    return [f"{beyond.sum()} of {len(beyond)} actions are clipped to 1"] if beyond.any() else []
