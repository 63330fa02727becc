"""The plan against OGBench's plan oracle and SciPy's filter."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from ogbench.manipspace import lie
from ogbench.manipspace.oracles.plan.cube_plan import CubePlanOracle
from scipy import stats
from scipy.ndimage import gaussian_filter1d

from pigbench.envs.oracles import plan
from pigbench.envs.oracles.targets import Target
from pigbench.envs.units import ACTION_SCALE, CONTROL_STEP

STEPS = CONTROL_STEP * np.arange(plan.MAX_STEPS)
EFFECTOR = np.array([0.35, -0.1, 0.3, 2.5, 0.0])
CUBE_POS, CUBE_YAW = np.array([0.45, 0.2, 0.02]), -1.0
TARGET = Target(cube=jnp.array(0), pos=jnp.array([0.35, -0.25, 0.06]), yaw=jnp.array(4.0))


def same_angle(ours, theirs, atol: float) -> None:
    np.testing.assert_allclose(
        np.exp(1j * np.asarray(ours)), np.exp(1j * np.asarray(theirs)), atol=atol
    )


@pytest.fixture(scope="module")
def oracle(ogbench_env) -> CubePlanOracle:
    return CubePlanOracle(env=ogbench_env("cube-double"), noise=0.0)


def to_pose(pose: np.ndarray) -> lie.SE3:
    return lie.SE3.from_rotation_and_translation(lie.SO3.from_z_radians(pose[3]), pose[:3])


def random_poses(rng: np.random.Generator, count: int) -> np.ndarray:
    """(count, 4): positions in the workspace and yaws."""
    return rng.uniform([0.25, -0.35, 0.02, -np.pi], [0.6, 0.35, 0.35, np.pi], (count, 4))


def test_grasp_yaw(oracle):
    rng = np.random.default_rng(0)
    for effector, cube in rng.uniform(-np.pi, np.pi, (200, 2)):
        yaws = [oracle.get_yaw(to_pose(np.array([0, 0, 0, yaw]))) for yaw in (effector, cube)]
        expected = oracle.shortest_yaw(*yaws, np.zeros(3)).rotation().compute_yaw_radians()
        same_angle(plan._grasp_yaw(jnp.array(effector), jnp.array(cube)), expected, atol=1e-5)


def test_screw_midpoint():
    rng = np.random.default_rng(1)
    for start, end in zip(random_poses(rng, 200), random_poses(rng, 200), strict=True):
        expected = lie.interpolate(to_pose(start), to_pose(end))
        ours = plan._screw_midpoint(jnp.array(start), jnp.array(end))
        # The bulge grows without bound as the turn comes near half a turn and a bit.
        np.testing.assert_allclose(ours[:3], expected.translation(), atol=1e-4)
        same_angle(ours[3], expected.rotation().compute_yaw_radians(), atol=1e-4)


def test_screw_midpoint_without_a_turn_is_the_middle():
    start, end = jnp.array([0.3, 0.1, 0.2, 1.0]), jnp.array([0.5, -0.1, 0.1, 1.0])
    np.testing.assert_allclose(plan._screw_midpoint(start, end), [0.4, 0.0, 0.15, 1.0], atol=1e-6)


def test_path_between_keyframes(oracle):
    """The same keyframes and times, through OGBench's interpolation without noise."""
    rng = np.random.default_rng(2)
    count = len(plan.KEYFRAMES)
    openings = [opening for _, opening in plan.KEYFRAMES.values()]
    interpolate = jax.jit(plan._interpolate)
    for _ in range(10):
        poses = random_poses(rng, count)
        times = plan._NOMINAL + np.r_[0, rng.uniform(-0.08, 0.08, count - 1)]
        oracle._t_max = times[-1]
        expected = oracle.compute_plan(list(times), [to_pose(pose) for pose in poses], openings)
        ours = np.asarray(interpolate(STEPS, times, poses))[: len(expected)]
        assert abs(len(expected) - np.sum(times[-1] > STEPS)) <= 1  # sums of 0.05 are not exact
        np.testing.assert_allclose(ours[:, :3], expected[:, :3], atol=1e-5)
        np.testing.assert_allclose(ours[:, 4], expected[:, 4], atol=1e-4)
        same_angle(ours[:, 3], expected[:, 3], atol=1e-4)


@pytest.mark.parametrize("length", [87, plan.MAX_STEPS])
def test_noise_is_white_noise_through_scipys_filter(length):
    key = jax.random.key(4)
    scale = 0.1 * np.array(ACTION_SCALE)
    white = np.asarray(jax.random.normal(key, (plan.MAX_STEPS, 5)), float)[:length] * scale
    expected = gaussian_filter1d(white, sigma=0.5, axis=0, mode="reflect")
    ours = plan._noise(key, jnp.array(length))[:length]
    np.testing.assert_allclose(ours, expected, atol=1e-6)


def test_the_plan_picks_and_places(monkeypatch):
    """Without noise: grip at the cube, let go at the target, end in the arm's start box."""
    monkeypatch.setattr(plan, "NOISE", 0.0)
    made = jax.jit(jax.vmap(plan.make, in_axes=(0, None, None, None, None)))(
        jax.random.split(jax.random.key(5), 100), EFFECTOR, CUBE_POS, CUBE_YAW, TARGET
    )
    paths = np.asarray(made.targets)
    np.testing.assert_allclose(paths[:, 0], np.tile(EFFECTOR, (100, 1)), atol=1e-6)

    def during(begin: float, end: float) -> np.ndarray:
        """Targets between two keyframes at these times, however they are jittered."""
        return paths[:, (begin + 0.08 <= STEPS) & (end - 0.08 >= STEPS)]

    at_pick, carried, at_place = during(1.0, 1.4), during(1.4, 3.2), during(3.2, 3.6)
    for stretch, pos, yaw in ((at_pick, CUBE_POS, CUBE_YAW), (at_place, TARGET.pos, TARGET.yaw)):
        np.testing.assert_allclose(
            stretch[..., :3], np.broadcast_to(pos, stretch[..., :3].shape), atol=1e-6
        )
        same_angle(4 * stretch[..., 3], 4 * yaw, atol=1e-4)  # up to quarter turns
    assert np.all(np.diff(at_pick[..., 4]) > 0)
    assert np.all(np.diff(at_place[..., 4]) < 0)
    np.testing.assert_allclose(carried[..., 4], 1.0, atol=1e-6)
    np.testing.assert_allclose(during(0.0, 1.0)[..., 4], 0.0, atol=1e-6)
    np.testing.assert_allclose(during(3.6, 4.4)[..., 4], 0.0, atol=1e-6)
    # 10 to 20 cm above the cube before the grasp, and the very same place after it.
    assert during(1.8, 2.2)[:, :1, 2].min() > CUBE_POS[2] + 0.1
    lengths = np.asarray(made.length)
    assert set(lengths) <= {87, 88, 89, 90}


def test_plans_are_distributed_as_ogbenchs(ogbench_env, numpy_seed):
    """Every coordinate of the plan, noise included, at times all along it."""
    oracle = CubePlanOracle(env=ogbench_env("cube-double"))
    ob_info = {
        "time": np.zeros(1),
        "proprio/effector_pos": EFFECTOR[:3],
        "proprio/effector_yaw": EFFECTOR[3:4],
        "privileged/target_block": 0,
        "privileged/block_0_pos": CUBE_POS,
        "privileged/block_0_yaw": np.array([CUBE_YAW]),
        "privileged/target_block_pos": np.array(TARGET.pos),
        "privileged/target_block_yaw": np.array([float(TARGET.yaw)]),
    }
    theirs, lengths = [], []
    with numpy_seed(0):
        for _ in range(400):
            oracle.reset(None, ob_info)
            theirs.append(oracle._plan[:87])
            lengths.append(len(oracle._plan))
    made = jax.jit(jax.vmap(plan.make, in_axes=(0, None, None, None, None)))(
        jax.random.split(jax.random.key(6), 4000), EFFECTOR, CUBE_POS, CUBE_YAW, TARGET
    )
    ours, theirs = np.asarray(made.targets), np.array(theirs)
    values = [
        stats.ks_2samp(ours[:, step, axis], theirs[:, step, axis]).pvalue
        for step in range(0, 87, 6)
        for axis in range(5)
    ]
    assert min(values) > 1e-3 / len(values)
    # Keyframes' order in time and neighbours' noise show in how far a plan moves in a step.
    moves = [
        np.linalg.norm(np.diff(paths[:, :87, :3], axis=1), axis=-1) for paths in (ours, theirs)
    ]
    values = [stats.ks_2samp(moves[0][:, i], moves[1][:, i]).pvalue for i in range(0, 86, 6)]
    assert min(values) > 1e-3 / len(values)
    counts = [
        [np.sum(np.asarray(rows) == length) for length in (87, 88, 89, 90)]
        for rows in (made.length, lengths)
    ]
    assert sum(counts[0]) == 4000
    assert stats.chi2_contingency(np.array(counts) + 1).pvalue > 1e-3
