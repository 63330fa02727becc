"""The closed form against OGBench's iterative solver and MuJoCo's forward kinematics."""

import jax
import mujoco
import numpy as np
import pytest
from ogbench.manipspace import lie

from pigbench.envs import kinematics, robot, workspace
from pigbench.envs.units import ACTION_SCALE

NAME = "cube-single"
HOME = np.array(robot.HOME)
inverse = jax.jit(kinematics.inverse)


def random_poses(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Pinch positions (count, 3) over the workspace, and yaws (count,)."""
    rng = np.random.default_rng(seed)
    return (
        rng.uniform(workspace.PINCH.low, workspace.PINCH.high, (count, 3)),
        rng.uniform(-np.pi, np.pi, count),
    )


@pytest.fixture(scope="module")
def solve(ogbench_env):
    """OGBench's joint angles for a pinch pose, gripper down, as its `set_control` asks for them."""
    env = ogbench_env(NAME)

    def solve(pos: np.ndarray, yaw: float, near: np.ndarray, **thresholds) -> np.ndarray:
        down = lie.SO3.from_z_radians(yaw) @ env._effector_down_rotation
        flange = lie.SE3.from_rotation_and_translation(down, pos) @ env._T_pa
        return env._ik.solve(
            pos=flange.translation(), quat=flange.rotation().wxyz, curr_qpos=near, **thresholds
        )

    return solve


@pytest.mark.parametrize(
    "thresholds", [{}, {"pos_thresh": 1e-7, "ori_thresh": 1e-7}], ids=["as is", "to the end"]
)
def test_moves_of_an_action_agree_with_ogbench(solve, thresholds):
    rng = np.random.default_rng(0)
    poses, yaws = random_poses(300, seed=1)
    joints = np.asarray(inverse(poses, yaws, np.tile(HOME, (300, 1))), float)
    moves = rng.uniform(-1, 1, (300, 4)) * ACTION_SCALE[:4]
    poses = np.clip(poses + moves[:, :3], workspace.PINCH.low, workspace.PINCH.high)
    yaws = yaws + moves[:, 3]
    ours = np.asarray(inverse(poses, yaws, joints))
    theirs = [solve(*problem, **thresholds) for problem in zip(poses, yaws, joints, strict=True)]
    print(f"largest difference {np.abs(ours - theirs).max():.1e} rad")
    np.testing.assert_allclose(ours, theirs, atol=1e-3)


@pytest.mark.parametrize("start", ["home", "anywhere"])
def test_far_poses_agree_with_ogbench_to_the_turn(solve, start):
    near = np.tile(HOME, (300, 1))
    if start == "anywhere":
        near = np.asarray(inverse(*random_poses(300, seed=5), near), float)
    poses, yaws = random_poses(300, seed=2)
    ours = np.asarray(inverse(poses, yaws, near))
    theirs = np.array([solve(*problem) for problem in zip(poses, yaws, near, strict=True)])
    # The last joint turns by more than half a turn, either way, in some of them.
    assert np.abs(ours[:, 5] - near[:, 5]).max() > np.pi
    np.testing.assert_allclose(ours, theirs, atol=1e-3)


def test_forward_kinematics_hits_the_pose(scene):
    built = scene(1)
    data = mujoco.MjData(built.model)
    poses, yaws = random_poses(500, seed=3)
    for pos, yaw, joints in zip(
        poses, yaws, inverse(poses, yaws, np.tile(HOME, (500, 1))), strict=True
    ):
        data.qpos[built.arm] = joints
        mujoco.mj_kinematics(built.model, data)
        pinch = data.site("pinch")
        np.testing.assert_allclose(pinch.xpos, pos, atol=1e-5)
        c, s = np.cos(yaw), np.sin(yaw)
        down = [[c, s, 0], [s, -c, 0], [0, 0, -1]]
        np.testing.assert_allclose(pinch.xmat.reshape(3, 3), down, atol=1e-5)


def test_joints_stay_inside_their_limits(scene):
    built = scene(1)
    low, high = built.model.jnt_range[:6].T
    poses, yaws = random_poses(2000, seed=4)
    joints = np.asarray(inverse(poses, yaws, np.tile(HOME, (2000, 1))))
    assert np.all((joints > low) & (joints < high))


def test_of_equal_solutions_the_nearest_is_taken():
    pos = np.array([0.4, 0.1, 0.2])
    joints = inverse(pos, 0.3, HOME)
    turned = HOME + 2 * np.pi * np.array([1, 0, 0, 0, 0, -1])
    np.testing.assert_allclose(inverse(pos, 0.3, turned) - joints, turned - HOME, atol=1e-5)


def test_leading_dimensions():
    poses, yaws = random_poses(6, seed=6)
    near = np.tile(HOME, (6, 1))
    flat = inverse(poses, yaws, near)
    grid = inverse(poses.reshape(2, 3, 3), yaws.reshape(2, 3), near.reshape(2, 3, 6))
    np.testing.assert_allclose(grid.reshape(6, 6), flat, atol=1e-6)


def test_out_of_reach_stretches_the_arm_towards_the_point():
    joints = inverse(np.array([3.0, 0.0, 0.2]), 0.0, HOME)
    assert np.all(np.isfinite(joints))
    np.testing.assert_allclose(joints[2], 0.0, atol=1e-6)  # the elbow
