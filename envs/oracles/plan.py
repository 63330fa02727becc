"""OGBench's plan oracle, which moves a cube by a noisy open-loop plan through keyframes."""

import jax
import jax.numpy as jnp
import numpy as np
from flax import struct
from jaxtyping import Array, Float, Int, PRNGKeyArray

from pigbench.envs import workspace
from pigbench.envs.oracles.targets import Target
from pigbench.envs.rotations import nearest_symmetry, wrap
from pigbench.envs.units import ACTION_SCALE, ACTION_SIZE, CONTROL_STEP

SEGMENT = 0.4  # seconds between keyframes
TIME_JITTER = 0.2  # share of a segment by which a keyframe may be early or late
NOISE = 0.1  # standard deviation of the plan's noise, in units of the action scale
NOISE_SMOOTHING = 0.5  # standard deviation of its Gaussian filter, in control steps
LIFT = (0.1, 0.2)  # metres above a cube at which it is approached and left
DETOUR = workspace.Box((-0.1, -0.1, 0.0), (0.1, 0.1, 0.2))  # of the carried cube, in metres

# Keyframe -> (segments since the previous one, gripper opening there), in the order of the plan.
KEYFRAMES = {
    "initial": (0.0, 0.0),
    "above_pick": (1.0, 0.0),
    "pick": (1.5, 0.0),
    "grasp": (1.0, 1.0),
    "lift": (1.0, 1.0),
    "clearance": (1.0, 1.0),
    "above_place": (1.0, 1.0),
    "place": (1.5, 1.0),
    "release": (1.0, 0.0),
    "retreat": (1.0, 0.0),
    "final": (1.0, 0.0),
}
_NOMINAL = SEGMENT * np.cumsum([segments for segments, _ in KEYFRAMES.values()])
_OPENINGS = np.array([opening for _, opening in KEYFRAMES.values()])
MAX_STEPS = int(np.ceil((_NOMINAL[-1] + SEGMENT * TIME_JITTER) / CONTROL_STEP))

_FILTER_RADIUS = int(4 * NOISE_SMOOTHING + 0.5)
_TAPS = np.arange(-_FILTER_RADIUS, _FILTER_RADIUS + 1)
_FILTER = np.exp(-0.5 * (_TAPS / NOISE_SMOOTHING) ** 2)
_FILTER /= _FILTER.sum()


@struct.dataclass
class Plan:
    """Effector targets, one per control step; the first `length` are used."""

    targets: Float[Array, "time action"]
    length: Int[Array, ""]


def make(
    key: PRNGKeyArray,
    effector: Float[Array, "action"],
    cube_pos: Float[Array, "3"],
    cube_yaw: Float[Array, ""],
    target: Target,
) -> Plan:
    """Plan to pick a cube at a pose and place it at `target`, ending at a random arm pose.

    Args:
        key: random key.
        effector: the effector's current position, yaw and opening.
        cube_pos: metres.
        cube_yaw: radians.
        target: where the cube goes.
    """
    noise_key, key = jax.random.split(key)
    # One call for all uniform draws, because each call costs compile time.
    lift_unit, detour_unit, final_unit, yaw_unit, time_unit = jnp.split(
        jax.random.uniform(key, (2 + 3 + 3 + 1 + len(KEYFRAMES),)), (2, 5, 8, 9)
    )
    poses = _keyframe_poses(
        effector[:4],
        jnp.append(cube_pos, _grasp_yaw(effector[3], cube_yaw)),
        target,
        lifts=LIFT[0] + lift_unit * (LIFT[1] - LIFT[0]),
        detour=DETOUR.point(detour_unit),
        final=jnp.append(workspace.PINCH_START.point(final_unit), jnp.pi * (2 * yaw_unit - 1)),
    )
    jitter = (2 * time_unit - 1).at[0].set(0.0)
    times = jnp.array(_NOMINAL) + SEGMENT * TIME_JITTER * jitter
    steps = CONTROL_STEP * jnp.arange(MAX_STEPS)
    length = jnp.sum(steps < times[-1])
    path = _interpolate(steps, times, jnp.stack([poses[name] for name in KEYFRAMES]))
    return Plan(path + _noise(noise_key, length), length)


def _keyframe_poses(
    initial: Float[Array, "4"],
    pick: Float[Array, "4"],
    target: Target,
    *,
    lifts: Float[Array, "2"],
    detour: Float[Array, "3"],
    final: Float[Array, "4"],
) -> dict[str, Float[Array, "4"]]:
    """The effector's pose (x, y, z, yaw) at each of `KEYFRAMES`.

    `lifts` are metres above the cube where it is picked and where it is placed; half-way between
    these, the effector is at its initial height, but for a `detour` in metres.
    """

    def above(pose: Float[Array, "4"], height: Float[Array, ""]) -> Float[Array, "4"]:
        return pose.at[2].add(height)

    lift = above(pick, lifts[0])
    place = jnp.append(target.pos, _grasp_yaw(pick[3], target.yaw))
    above_place = above(place, lifts[1])
    clearance = _screw_midpoint(lift, above_place).at[2].set(initial[2]).at[:3].add(detour)
    return {
        "initial": initial,
        "above_pick": lift,
        "pick": pick,
        "grasp": pick,
        "lift": lift,
        "clearance": clearance,
        "above_place": above_place,
        "place": place,
        "release": place,
        "retreat": above_place,
        "final": final,
    }


def _grasp_yaw(effector_yaw: Float[Array, ""], cube_yaw: Float[Array, ""]) -> Float[Array, ""]:
    """The yaw in [0, 2 pi) at which to grip the cube, up to symmetry nearest to the effector's."""
    full = 2 * jnp.pi
    return jnp.mod(nearest_symmetry(jnp.mod(cube_yaw, full), jnp.mod(effector_yaw, full)), full)


def _screw_midpoint(start: Float[Array, "4"], end: Float[Array, "4"]) -> Float[Array, "4"]:
    """The midpoint of a screw motion about the vertical between two poses (x, y, z, yaw)."""
    turn = wrap(end[3] - start[3])
    dx, dy = end[0] - start[0], end[1] - start[1]
    bulge = 0.5 * jnp.tan(turn / 4) * jnp.stack([dy, -dx])
    middle = (start + end) / 2
    return middle.at[:2].add(bulge).at[3].set(start[3] + turn / 2)


def _interpolate(
    steps: Float[Array, "time"],
    times: Float[Array, "keyframe"],
    poses: Float[Array, "keyframe 4"],
) -> Float[Array, "time action"]:
    """Targets at `steps`: linear between keyframes, yaw the shorter way round."""
    keyframes = jnp.concatenate([poses, jnp.array(_OPENINGS)[:, None]], axis=-1)
    changes = jnp.diff(keyframes, axis=0)
    changes = changes.at[:, 3].set(wrap(changes[:, 3]))
    # A sum over segments, each weighted by the fraction done, needs no search and no gather.
    done = jnp.clip((steps[:, None] - times[:-1]) / jnp.diff(times), 0.0, 1.0)
    path = keyframes[0] + jnp.matmul(done, changes, precision="highest")
    return path.at[:, 3].set(wrap(path[:, 3]))


def _noise(key: PRNGKeyArray, length: Int[Array, ""]) -> Float[Array, "time action"]:
    """White noise smoothed along the plan and reflected at its ends."""
    white = jax.random.normal(key, (MAX_STEPS, ACTION_SIZE)) * NOISE * jnp.array(ACTION_SCALE)
    white = jnp.pad(white, ((0, _FILTER_RADIUS), (0, 0)))
    mirrored = jnp.roll(white[::-1], 2 * length - len(white), axis=0)  # white[2 length - 1 - i]
    reflected = jnp.where(jnp.arange(len(white))[:, None] < length, white, mirrored)
    padded = jnp.concatenate([white[:_FILTER_RADIUS][::-1], reflected])
    taps = (weight * padded[i : i + MAX_STEPS] for i, weight in enumerate(_FILTER))
    return sum(taps, start=jnp.zeros(ACTION_SIZE))
