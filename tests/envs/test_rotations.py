"""Against SciPy's rotations and OGBench's search over symmetries."""

import jax.numpy as jnp
import numpy as np
from ogbench.manipspace.oracles.plan.plan_oracle import PlanOracle
from scipy.spatial.transform import Rotation

from pigbench.envs import rotations


def test_wrap_keeps_the_angle_and_brings_it_into_one_turn():
    angles = np.random.default_rng(0).uniform(-30, 30, 500)
    wrapped = np.asarray(rotations.wrap(jnp.asarray(angles)))
    assert np.all((wrapped >= -np.pi) & (wrapped < np.pi))
    np.testing.assert_allclose(np.exp(1j * wrapped), np.exp(1j * angles), atol=1e-5)


def test_nearest_turn():
    # 0.5 is one turn less than 6.78..., whose nearest neighbour to 7 it is.
    turned = rotations.nearest_turn(jnp.array([0.5, 0.5, 3.0]), jnp.array([7.0, -1.0, -3.0]))
    np.testing.assert_allclose(turned, [0.5 + 2 * np.pi, 0.5, 3.0 - 2 * np.pi], atol=1e-6)


def test_yaw_quat_turns_about_z():
    yaws = np.random.default_rng(0).uniform(-7, 7, (4, 5))
    quats = np.asarray(rotations.yaw_quat(jnp.asarray(yaws)))
    assert quats.shape == (4, 5, 4)
    turned = Rotation.from_quat(quats.reshape(-1, 4), scalar_first=True).as_matrix()
    expected = Rotation.from_euler("z", yaws.reshape(-1, 1)).as_matrix()
    np.testing.assert_allclose(turned, expected, atol=1e-5)


def test_quat_yaw_is_the_yaw_of_roll_pitch_yaw():
    random = Rotation.random(300, rng=np.random.default_rng(0))
    yaw = np.asarray(rotations.quat_yaw(jnp.asarray(random.as_quat(scalar_first=True))))
    expected = random.as_euler("ZYX")[:, 0]
    np.testing.assert_allclose(np.exp(1j * yaw), np.exp(1j * expected), atol=1e-4)


def test_nearest_symmetry_finds_what_ogbench_searches():
    rng = np.random.default_rng(0)
    for effector, cube in rng.uniform(0, 2 * np.pi, (200, 2)):
        pose = PlanOracle.shortest_yaw(None, effector, cube, np.zeros(3))
        expected = pose.rotation().compute_yaw_radians()
        found = rotations.nearest_symmetry(jnp.asarray(cube), jnp.asarray(effector))
        assert abs(found - effector) <= np.pi / 4 + 1e-5
        np.testing.assert_allclose(np.exp(1j * found), np.exp(1j * expected), atol=1e-5)


def test_rotation_matrices_and_vectors():
    random = Rotation.random(100, rng=np.random.default_rng(1))
    for rotation in random:
        quat = 2.5 * rotation.as_quat(scalar_first=True)
        np.testing.assert_allclose(rotations.quat_rotation(quat), rotation.as_matrix(), atol=1e-5)
        vector = 0.9 * rotation.as_rotvec()
        angle = jnp.asarray(np.linalg.norm(vector))
        matrix = rotations.axis_rotation(vector / np.linalg.norm(vector), angle)
        np.testing.assert_allclose(matrix, Rotation.from_rotvec(vector).as_matrix(), atol=1e-5)
        np.testing.assert_allclose(rotations.rotation_vector(matrix), vector, atol=2e-4)
    np.testing.assert_array_equal(rotations.rotation_vector(jnp.eye(3)), 0)
