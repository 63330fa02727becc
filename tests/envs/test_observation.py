"""The observation at equal qpos and qvel, against OGBench's."""

import jax
import mujoco
import numpy as np
import pytest

from pigbench.envs import observation, terms
from pigbench.envs.physics.mujoco import MujocoPhysics

SIZES = {"cube-single": 1, "cube-double": 2, "cube-triple": 3, "cube-quadruple": 4}
STEPS = {name: 1500 if name == "cube-double" else 400 for name in SIZES}


@pytest.mark.parametrize("num_cubes", [1, 2, 3, 4, 8])
def test_layout(num_cubes):
    layout = terms.layout(num_cubes)
    assert layout.size == 28 + 9 * (num_cubes - 1)
    cubes = [f"cube_{i}_{term}" for i in range(num_cubes) for term in ("pos", "quat", "yaw")]
    robot = ["joint_pos", "joint_vel", "effector_pos", "effector_yaw"]
    assert list(layout) == [*robot, "gripper_opening", "gripper_contact", *cubes]
    assert len(layout) == 6 + 3 * num_cubes


def test_terms_that_are_not_observed_are_left_out():
    layout = terms.layout(1, unobserved={"effector_pos"})
    assert layout == terms.layout(1).subset(set(terms.layout(1)) - {"effector_pos"})
    assert layout["cube_0_pos"] == slice(16, 19)


def test_names_tell_the_robots_terms_from_the_cubes():
    layout = terms.layout(8)
    assert list(layout.group("robot")) == [term.name for term in terms.ROBOT_TERMS]
    assert list(layout.group("objects")) == list(layout)[len(terms.ROBOT_TERMS) :]
    assert list(layout.group("object_positions")) == [f"cube_{i}_pos" for i in range(8)]
    assert list(layout.group("velocities")) == ["joint_vel"]


def stacked_qpos(home: np.ndarray, num_cubes: int) -> np.ndarray:
    """All cubes in one stack, each turned a little more."""
    qpos = home.copy()
    for i in range(num_cubes):
        yaw = 0.2 * i
        quat = [np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)]
        qpos[14 + 7 * i : 21 + 7 * i] = [0.35, 0.25, 0.0199 + 0.0399 * i, *quat]
    return qpos


def worst_differences(scene, place, name: str, qpos: np.ndarray, qvel: np.ndarray):
    """Largest differences over the states: of the contact number, and of all others."""
    qpos, qvel = np.float32(qpos), np.float32(qvel)
    built, layout = scene(SIZES[name]), terms.layout(SIZES[name])
    states = jax.jit(jax.vmap(MujocoPhysics(built).init))(qpos, qvel)
    ours = jax.vmap(lambda state: observation.observe(layout, built, state))(states)
    assert ours.dtype == np.float32
    theirs = [place(name, *state).compute_observation() for state in zip(qpos, qvel, strict=True)]
    difference = np.abs(ours - np.array(theirs))
    contact = layout["gripper_contact"]
    return difference[:, contact].max(), np.delete(difference, contact, axis=1).max()


@pytest.mark.parametrize("name", SIZES)
@pytest.mark.parametrize("kind", ["free", "grasping", "stacked"])
def test_observation(scene, play, place, name, kind):
    recording = play(name, STEPS[name])
    qpos, qvel = recording.qpos, recording.qvel
    if kind == "stacked":
        qpos = stacked_qpos(scene(SIZES[name]).home_qpos, SIZES[name])[None]
        qvel = np.zeros_like(qvel[:1])
    else:
        grasping = recording.contact > 0.1
        rows = np.flatnonzero(grasping if kind == "grasping" else ~grasping)
        rows = rows[:: max(1, len(rows) // 40)]
        assert len(rows) >= 20
        qpos, qvel = qpos[rows], qvel[rows]
    contact, rest = worst_differences(scene, place, name, qpos, qvel)
    print(f"{name}, {kind}: contact {contact:.1e}, rest {rest:.1e}")
    assert contact <= 0.05
    assert rest <= 1e-4


def test_stacks_of_play(scene, play, place):
    recording = play("cube-double", STEPS["cube-double"])
    rows = np.flatnonzero(recording.stacked)[::5]
    assert len(rows) >= 10
    contact, rest = worst_differences(
        scene, place, "cube-double", recording.qpos[rows], recording.qvel[rows]
    )
    assert contact <= 0.05
    assert rest <= 1e-4


def test_after_a_control_step(scene, play, ogbench_env):
    """Pinch and contact lag qpos by one substep in both."""
    name = "cube-double"
    recording, built, layout = play(name, STEPS[name]), scene(2), terms.layout(2)
    rows = np.linspace(0, len(recording.qpos) - 1, 60).astype(int)
    physics = MujocoPhysics(built)
    qpos, qvel, ctrl = (
        np.float32(x[rows]) for x in (recording.qpos, recording.qvel, recording.ctrl)
    )
    states = jax.vmap(physics.step)(jax.vmap(physics.init)(qpos, qvel), ctrl)
    ours = jax.vmap(lambda state: observation.observe(layout, built, state))(states)
    env = ogbench_env(name)
    for row in range(len(rows)):
        env.set_state(qpos[row], qvel[row])
        env.data.ctrl[:] = ctrl[row]
        mujoco.mj_step(env.model, env.data, nstep=25)
        mujoco.mj_rnePostConstraint(env.model, env.data)
        difference = np.abs(ours[row] - env.compute_observation())
        contact = layout["gripper_contact"]
        assert difference[contact] <= 0.05
        assert np.delete(difference, contact).max() <= 1e-4


def test_opening_and_contact_are_clipped(scene):
    built, layout = scene(1), terms.layout(1)
    state = MujocoPhysics(built).init(built.home_qpos)
    state = state.replace(qpos=state.qpos.at[built.driver].set(0.9), pad_force=np.float32(1000.0))
    observed = observation.observe(layout, built, state)
    assert observed[layout["gripper_opening"]] == 3.0
    assert observed[layout["gripper_contact"]] == 1.0
