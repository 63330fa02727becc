"""Joint targets against OGBench's solver, and its parts against MuJoCo and NumPy."""

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import pytest
from ogbench.manipspace import lie

from pigbench.envs import robot, servo, workspace
from pigbench.envs.units import ACTION_SCALE

NAME = "cube-double"


def test_targets_are_those_of_ogbenchs_solver_where_it_stops(ogbench_env, play):
    env, recording = ogbench_env(NAME), play(NAME, 1500)
    rng = np.random.default_rng(0)
    rows = rng.integers(0, 1500, 200)
    joints = recording.qpos[rows, :6]
    model = env.model
    targets, starts = [], []
    for qpos in recording.qpos[rows]:
        data = mujoco.MjData(model)
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        site = data.site("ur5e/robotiq/pinch")
        move = rng.uniform(-1, 1, 4) * ACTION_SCALE[:4]
        pos = np.clip(site.xpos + move[:3], workspace.PINCH.low, workspace.PINCH.high)
        yaw = lie.SO3.from_matrix(site.xmat.reshape(3, 3)).compute_yaw_radians() + move[3]
        down = lie.SO3.from_z_radians(yaw) @ env._effector_down_rotation
        flange = lie.SE3.from_rotation_and_translation(down, pos) @ env._T_pa
        starts.append((pos, yaw))
        targets.append(
            env._ik.solve(pos=flange.translation(), quat=flange.rotation().wxyz, curr_qpos=qpos[:6])
        )
    pos, yaw = (np.array(x) for x in zip(*starts, strict=True))
    ours = np.asarray(jax.jit(jax.vmap(servo.joint_targets))(pos, yaw, joints))
    errors = np.abs(ours - targets).max(axis=-1)
    print(f"median {np.median(errors):.1e}, largest {errors.max():.1e} rad")
    # Where single precision decides otherwise whether to stop, a step of 1e-4 rad more is taken.
    assert np.quantile(errors, 0.98) < 3e-6
    assert errors.max() < 5e-4


def test_forward_kinematics_is_mujocos(scene):
    model = scene(1).model
    data = mujoco.MjData(model)
    rng = np.random.default_rng(1)
    forward, to_pinch = jax.jit(servo.flange), jax.jit(servo.pinch)
    for joints in rng.uniform(-3, 3, (20, 6)):
        data.qpos[:6] = joints
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        pos, rotation, axes, anchors = forward(joints)
        body = data.body("wrist_3")
        expected = body.xpos + body.xmat.reshape(3, 3) @ [0, robot.FLANGE_OFFSET, 0]
        np.testing.assert_allclose(pos, expected, atol=2e-6)
        np.testing.assert_allclose(rotation, body.xmat.reshape(3, 3), atol=3e-6)
        np.testing.assert_allclose(axes, data.xaxis[:6], atol=3e-6)
        np.testing.assert_allclose(anchors, data.xanchor[:6], atol=2e-6)
        site, (pinch, yaw) = data.site("pinch"), to_pinch(joints)
        np.testing.assert_allclose(pinch, site.xpos, atol=3e-6)
        np.testing.assert_allclose(yaw, np.arctan2(site.xmat[3], site.xmat[0]), atol=3e-4)


def test_solves_linear_systems_as_numpy():
    rng = np.random.default_rng(2)
    matrices = rng.normal(size=(50, 6, 6))
    matrices[:10, 0, 0] = 0  # a pivot must be sought
    vectors = rng.normal(size=(50, 6))
    ours = jax.vmap(servo._solve)(matrices, vectors)
    expected = np.linalg.solve(matrices, vectors[..., None])[..., 0]
    scale = np.linalg.cond(matrices) * np.abs(expected).max(axis=-1)
    assert np.all(np.abs(ours - expected).max(axis=-1) < 1e-5 * scale)


@pytest.mark.parametrize("far", [1.0, 3.0])
def test_a_point_out_of_reach_gives_finite_angles(far):
    joints = jnp.array(robot.HOME)
    target = servo.joint_targets(jnp.array([far, 0.0, 0.2]), jnp.array(0.0), joints)
    assert np.all(np.isfinite(target))
