"""Replay of OGBench's recorded actions from the same states, and the resulting differences."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, Shaped

from pigbench import envs
from pigbench.envs.contact import CARRYING, FREE, TOUCHING
from pigbench.envs.cubes import CUBE_HALF_SIZE
from pigbench.envs.observation import (
    cube_poses,
    gripper_contact,
    gripper_opening,
)
from pigbench.envs.physics import PhysicsState
from pigbench.envs.scene import Scene
from pigbench.envs.spec import SUCCESS_DISTANCE
from pigbench.envs.units import PAD_FORCE_SCALE
from pigbench.fidelity.recording import PeerRecording

WINDOW = 50  # control steps
TOUCH = 0.01  # contact above which the gripper touches something
LIFTED = 2 * CUBE_HALF_SIZE  # metres above the table beyond which a cube's centre is lifted
SITUATIONS = FREE, TOUCHING, CARRYING


class SceneMotion(NamedTuple):
    """The compared quantities of simulations after each control step."""

    pinch_pos: Float[np.ndarray, "time simulation 3"]  # metres
    opening: Float[np.ndarray, "time simulation"]
    contact: Float[np.ndarray, "time simulation"]
    cube_pos: Float[np.ndarray, "time simulation cube 3"]  # metres
    cube_quat: Float[np.ndarray, "time simulation cube 4"]


class Errors(NamedTuple):
    """Differences between two motions; those of cubes are the largest over cubes."""

    pinch: Float[np.ndarray, "time simulation"]  # metres
    opening: Float[np.ndarray, "time simulation"]
    contact: Float[np.ndarray, "time simulation"]
    cube: Float[np.ndarray, "time simulation"]  # metres
    turn: Float[np.ndarray, "time simulation"]  # radians


class Windows(NamedTuple):
    """Windows of WINDOW control steps, and the errors in each."""

    situations: Shaped[np.ndarray, "time window"]  # FREE, TOUCHING or CARRYING at some time so far
    errors: Errors


class Outcomes(NamedTuple):
    """Outcomes of whole sub-tasks: as recorded, and as replayed here."""

    grasped: Bool[np.ndarray, "subtask"]
    placed: Bool[np.ndarray, "subtask"]
    grasped_here: Bool[np.ndarray, "subtask"]
    placed_here: Bool[np.ndarray, "subtask"]


def windows(env: "envs.CubeEnv", recordings: Sequence[PeerRecording]) -> Windows:
    """Replay consecutive, disjoint windows of all recordings."""
    places = [
        (recording, begin)
        for recording in recordings
        for begin in range(0, len(recording.actions) - WINDOW + 1, WINDOW)
    ]
    ours = _replay(env, places, WINDOW)
    theirs = _recorded(env.scene, places, WINDOW)
    return Windows(_situations(theirs), _errors(ours, theirs))


def outcomes(env: "envs.CubeEnv", recordings: Sequence[PeerRecording]) -> Outcomes:
    """Replay whole sub-tasks; those cut off by an episode's end are left out."""
    places, lengths = [], []
    for recording in recordings:
        ends = np.flatnonzero(recording.ended) + 1
        for begin, end in zip([0, *ends[:-1]], ends, strict=True):
            places.append((recording, int(begin)))
            lengths.append(int(end - begin))
    ours = _replay(env, places, max(lengths))
    theirs = _recorded(env.scene, places, max(lengths))
    here, there = (_outcome(motion, places, np.array(lengths)) for motion in (ours, theirs))
    return Outcomes(*there, *here)


Places = Sequence[tuple[PeerRecording, int]]
"""Recordings and the rows from which they are replayed."""


def _replay(env: "envs.CubeEnv", places: Places, steps: int) -> SceneMotion:
    """Simulate here from the recorded states, with the recorded actions."""
    blank = jax.device_get(jax.jit(env.physics.init)(jnp.asarray(env.scene.home_qpos)))
    starts = [_start(blank, recording, row) for recording, row in places]
    states = jax.tree.map(lambda *leaves: np.stack(leaves), *starts)
    actions = np.stack([_stretch(r.actions, row, steps) for r, row in places], axis=1)

    @jax.jit
    def run(states: PhysicsState, actions: Float[Array, "time simulation action"]) -> PhysicsState:
        def step(
            states: PhysicsState, actions: Float[Array, "simulation action"]
        ) -> tuple[PhysicsState, PhysicsState]:
            states = jax.vmap(env.simulate)(states, actions)
            return states, states

        return jax.lax.scan(step, states, actions)[1]

    trajectory = run(states, actions.astype(np.float32))
    position, quat = jax.vmap(jax.vmap(partial(cube_poses, env.scene)))(trajectory)
    return SceneMotion(
        pinch_pos=np.asarray(trajectory.pinch_pos),
        opening=np.asarray(jax.vmap(jax.vmap(partial(gripper_opening, env.scene)))(trajectory)),
        contact=np.asarray(gripper_contact(trajectory)),
        cube_pos=np.asarray(position),
        cube_quat=np.asarray(quat),
    )


def _start(blank: PhysicsState, recording: PeerRecording, row: int) -> PhysicsState:
    """The recorded state, with what a control step passes on to the next."""
    return replace(
        blank,
        qpos=np.float32(recording.qpos[row]),
        qvel=np.float32(recording.qvel[row]),
        warmstart=np.float32(recording.warmstart[row]),
        pinch_pos=np.float32(recording.pinch_pos[row]),
        pinch_yaw=np.float32(recording.pinch_yaw[row]),
        pad_force=np.float32(recording.contact[row] / PAD_FORCE_SCALE),
    )


def _recorded(scene: Scene, places: Places, steps: int) -> SceneMotion:
    def column(name: str) -> Shaped[np.ndarray, "time simulation *value"]:
        return np.stack([_stretch(getattr(r, name)[1:], row, steps) for r, row in places], axis=1)

    poses = column("qpos")[..., scene.cubes_qpos]
    poses = poses.reshape(*poses.shape[:2], scene.num_cubes, 7)
    return SceneMotion(
        pinch_pos=column("pinch_pos"),
        opening=column("opening"),
        contact=column("contact"),
        cube_pos=poses[..., :3],
        cube_quat=poses[..., 3:],
    )


def _stretch(
    rows: Shaped[np.ndarray, "row *value"], begin: int, steps: int
) -> Shaped[np.ndarray, "time *value"]:
    """`steps` rows from `begin`; the last row is repeated beyond the end."""
    return rows[np.minimum(np.arange(begin, begin + steps), len(rows) - 1)]


def _errors(ours: SceneMotion, theirs: SceneMotion) -> Errors:
    def distance(name: str) -> Float[np.ndarray, "*axes"]:
        return np.linalg.norm(getattr(ours, name) - getattr(theirs, name), axis=-1)

    # A quaternion and its negative are the same orientation.
    chords = [np.linalg.norm(ours.cube_quat + s * theirs.cube_quat, axis=-1) for s in (1, -1)]
    return Errors(
        pinch=distance("pinch_pos"),
        opening=np.abs(ours.opening - theirs.opening),
        contact=np.abs(ours.contact - theirs.contact),
        cube=distance("cube_pos").max(axis=-1),
        turn=4 * np.arcsin(np.minimum(*chords) / 2).max(axis=-1),
    )


def _situations(motion: SceneMotion) -> Shaped[np.ndarray, "time simulation"]:
    touching = motion.contact > TOUCH
    carrying = touching & (motion.cube_pos[..., 2] > LIFTED).any(axis=-1)
    so_far = [np.logical_or.accumulate(flags) for flags in (carrying, touching)]
    return np.select(so_far, [CARRYING, TOUCHING], FREE)


def _outcome(
    motion: SceneMotion, places: Places, lengths: Int[np.ndarray, "subtask"]
) -> tuple[Bool[np.ndarray, "subtask"], Bool[np.ndarray, "subtask"]]:
    """Whether the sub-task's cube was ever grasped, and whether it ended at its target."""
    number = np.arange(len(places))
    cubes = np.array([recording.cube[row] for recording, row in places])
    targets = np.array([recording.target[row] for recording, row in places])
    cube = motion.cube_pos[:, number, cubes]
    under_way = np.arange(len(cube))[:, None] < lengths
    risen = cube[..., 2] > cube[0, :, 2] + CUBE_HALF_SIZE
    grasped = np.asarray((risen & (motion.contact > TOUCH) & under_way).any(axis=0))
    last = cube[lengths - 1, number]
    placed = np.linalg.norm(last - targets, axis=-1) <= SUCCESS_DISTANCE
    return grasped, placed
