"""Servo targets against what OGBench's `set_control` writes, at the same states and actions."""

import jax
import numpy as np
import pytest
from ogbench.manipspace.lie import SO3

from pigbench.envs import control
from pigbench.envs.physics.mujoco import MujocoPhysics
from pigbench.envs.units import ACTION_SCALE, ACTION_SIZE

NAME = "cube-double"
STATES = 100


@pytest.fixture(scope="module")
def states(scene, play):
    """Ours at states of OGBench's play, gripper tilted by what the servos lag."""
    recording = play(NAME, 1500)
    rows = np.linspace(0, 1499, STATES).astype(int)
    qpos, qvel = (np.float32(x[rows]) for x in (recording.qpos, recording.qvel))
    return jax.jit(jax.vmap(MujocoPhysics(scene(2)).init))(qpos, qvel)


def actions(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-1, 1, (STATES, 5)).astype(np.float32)


def test_action_scale(ogbench_env):
    env = ogbench_env(NAME)
    np.testing.assert_array_equal(ACTION_SCALE, env.action_high)
    np.testing.assert_array_equal(ACTION_SCALE, -env.action_low)
    assert env.action_space.shape == (ACTION_SIZE,)


@pytest.mark.parametrize("scale", [1, 4], ids=["within", "beyond"])
def test_servo_targets(scene, place, states, scale):
    """Of actions beyond [-1, 1] too: OGBench clips where they lead, not how far."""
    given = scale * actions(0)
    ours = jax.vmap(lambda state, action: control.servo_targets(scene(2), state, action))(
        states, given
    )
    for row in range(STATES):
        env = place(NAME, states.qpos[row], states.qvel[row])
        env.set_control(given[row])
        np.testing.assert_allclose(ours[row, :6], env.data.ctrl[:6], atol=2e-3)
        np.testing.assert_allclose(ours[row, 6], env.data.ctrl[6], atol=1e-2)


def test_targets_stay_in_the_workspace(scene, states):
    """Beyond the corner, the target is what standing still at the corner asks for."""
    targets = jax.jit(lambda *given: control.servo_targets(scene(2), *given))
    state = jax.tree.map(lambda x: x[0], states)
    near = state.replace(pinch_pos=np.float32([0.26, -0.34, 0.03]))
    corner = state.replace(pinch_pos=np.float32([0.25, -0.35, 0.02]))
    outward, still = np.float32([-1, -1, -1, 0, 0]), np.zeros(5, np.float32)
    np.testing.assert_allclose(targets(near, outward), targets(corner, still), atol=1e-5)
    shut = targets(state, np.float32([0, 0, 0, 0, 1]))
    np.testing.assert_allclose([shut[6], targets(state, -np.eye(5)[4])[6]], [255, 0], atol=1e-3)


def test_action_towards_is_what_ogbenchs_oracle_asks_for(scene, place, states):
    targets = np.random.default_rng(1).uniform(
        [0.25, -0.35, 0.02, -np.pi, 0], [0.6, 0.35, 0.35, np.pi, 1], (STATES, 5)
    )
    ours = jax.vmap(lambda state, target: control.action_towards(scene(2), state, target))(
        states, targets
    )
    for row in range(STATES):
        env = place(NAME, states.qpos[row], states.qvel[row])
        info = env.compute_ob_info()
        names = ("effector_pos", "effector_yaw", "gripper_opening")
        effector = np.concatenate([info[f"proprio/{name}"] for name in names])
        expected = env.normalize_action(targets[row] - effector)
        np.testing.assert_allclose(ours[row], expected, atol=1e-4)


def test_effector(scene, place, states):
    ours = jax.vmap(lambda state: control.effector(scene(2), state))(states)
    for row in range(STATES):
        env = place(NAME, states.qpos[row], states.qvel[row])
        pinch = env.data.site("ur5e/robotiq/pinch")
        yaw = SO3.from_matrix(pinch.xmat.reshape(3, 3)).compute_yaw_radians()
        opening = np.clip(env.data.joint("ur5e/robotiq/right_driver_joint").qpos / 0.8, 0, 1)
        np.testing.assert_allclose(ours[row], [*pinch.xpos, yaw, *opening], atol=1e-5)
