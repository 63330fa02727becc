from types import SimpleNamespace

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import pytest

from pigbench import envs
from pigbench.agents import GoalMixture, Sampling
from pigbench.agents.representations import Representation
from pigbench.agents.statistics import Statistics
from pigbench.analysis import grasps
from pigbench.envs import workspace
from pigbench.envs.kinematics import inverse
from pigbench.envs.terms import layout
from pigbench.fidelity import peer

STEPS = 5
LENGTH = 60
LAYOUT = layout(2)
TAKEN, LIFTED, CARRIED = 20, 23, 30  # rows at which the gripper does so


def observations() -> np.ndarray:
    """An episode: the second cube is taken up and carried; positions are numbers of a row."""
    rows = np.arange(LENGTH)
    values = np.zeros((LENGTH, LAYOUT.size), np.float32)
    cube = np.tile([0.1, -0.2, 0.02], (LENGTH, 1))
    cube[LIFTED:, 2] += 0.01 * (rows[LIFTED:] - LIFTED)
    cube[CARRIED:, 0] += 0.01 * (rows[CARRIED:] - CARRIED)
    values[:, LAYOUT["cube_0_pos"]] = 3.0
    values[:, LAYOUT["cube_1_pos"]] = 10 * cube
    values[:, LAYOUT["effector_pos"]] = 10 * (cube + np.array([0.004, 0.003, 0.01]))
    values[TAKEN:, LAYOUT["gripper_contact"]] = 0.5
    values[:, LAYOUT["joint_pos"]] = rows[:, None]
    return values


def make_split(values: np.ndarray, episodes: int = 1) -> SimpleNamespace:
    size = len(values)
    fields = {
        "observations": np.tile(values, (episodes, 1)),
        "actions": np.zeros((episodes * size, 5)),
        "terminals": np.tile(np.arange(size) == size - 1, episodes),
    }
    return SimpleNamespace(concatenate=fields.__getitem__)


def make_agent(**mixture) -> SimpleNamespace:
    goals = GoalMixture(**mixture)
    return SimpleNamespace(
        config=SimpleNamespace(subgoal_steps=STEPS), sampling=Sampling(goals, goals, 0.99)
    )


UNIFORM = {"current": 0.2, "future": 0.5, "random": 0.3, "geometric": False}


def row_numbers(values: np.ndarray) -> np.ndarray:
    return values[:, LAYOUT["joint_pos"]][:, 0].astype(int)


def test_states_before_grasps_with_far_goals_of_the_same_episode():
    values = observations()
    drawn = grasps.draw(make_split(values), make_agent(**UNIFORM), LAYOUT, samples=10**6, seed=0)
    starts, ahead, goals = map(row_numbers, drawn[:3])
    assert set(starts) == set(range(TAKEN - STEPS, TAKEN))
    np.testing.assert_array_equal(ahead, starts + STEPS)
    assert (goals > starts + 2 * STEPS).all()
    assert goals.max() == LENGTH - 1
    np.testing.assert_allclose(drawn.cube, np.tile([0.525, -0.2], (len(starts), 1)), atol=1e-6)
    few = grasps.draw(make_split(values), make_agent(**UNIFORM), LAYOUT, samples=7, seed=0)
    np.testing.assert_array_equal(few.goals, drawn.goals[:7])


def test_goals_of_other_episodes_do_not_count():
    """Only random goals: those of the same episode are far fewer with more episodes."""
    split = make_split(observations(), episodes=10)
    random = {"current": 0.0, "future": 0.0, "random": 1.0, "geometric": False}
    drawn = grasps.draw(split, make_agent(**random), LAYOUT, samples=10**6, seed=0)
    # Of a start at row r of 60, the 49 - r last rows of its episode count among 600.
    shares = [(LENGTH - 1 - row - 2 * STEPS) / 600 for row in range(TAKEN - STEPS, TAKEN)]
    assert len(drawn.starts) == pytest.approx(200_000 / 59 * np.sum(shares), rel=0.1)


def test_a_cube_that_is_moved_meanwhile_is_left_out():
    values = observations()
    values[TAKEN, LAYOUT["cube_1_pos"]] += 0.2  # 2 cm
    values[TAKEN, LAYOUT["effector_pos"]] += 0.2
    drawn = grasps.draw(make_split(values), make_agent(**UNIFORM), LAYOUT, samples=10**6, seed=0)
    assert set(row_numbers(drawn.starts)) == set(range(TAKEN - STEPS + 1, TAKEN))


def test_data_without_grasps_give_none():
    values = observations()
    values[:, LAYOUT["gripper_contact"]] = 0
    drawn = grasps.draw(make_split(values), make_agent(**UNIFORM), LAYOUT, samples=9, seed=0)
    assert len(drawn.starts) == len(drawn.cube) == 0


@pytest.mark.parametrize("name", ["joints_contacts", "proprio", "full"])
@pytest.mark.parametrize("standardized", [True, False])
def test_pinch_points_are_those_of_ogbenchs_model(name, standardized):
    """Whether a subgoal tells them or they follow from its joints."""
    env = envs.make("cube-single")
    simulator = peer.make("cube-single", mode="data_collection")
    simulator.reset(seed=0)
    rng = np.random.default_rng(0)
    points = rng.uniform(workspace.PINCH.low, workspace.PINCH.high, (20, 3))
    home = np.array(env.scene.home_qpos)[env.scene.arm]
    given = points, rng.uniform(-3, 3, 20), np.tile(home, (20, 1))
    joints = np.asarray(inverse(*map(jnp.asarray, given)))
    joints = joints + rng.normal(0, 0.1, joints.shape)  # no longer straight down
    values = np.zeros((20, env.layout.size), np.float32)
    expected = np.zeros((20, 3))
    for row, angles in enumerate(joints):
        simulator.data.qpos[simulator._arm_joint_ids] = angles
        mujoco.mj_kinematics(simulator.model, simulator.data)
        expected[row] = simulator.data.site_xpos[simulator._pinch_site_id]
    values[:, env.layout["joint_pos"]] = joints
    values[:, env.layout["effector_pos"]] = 10 * (expected - [0.425, 0, 0])
    statistics = Statistics.of(rng.normal(size=(50, env.layout.size)).astype(np.float32))
    represent = Representation(name, env.layout, statistics if standardized else None)
    agent = SimpleNamespace(represent=represent)
    pinch = grasps.pinch(agent, represent(jax.numpy.asarray(values)))
    np.testing.assert_allclose(pinch, expected, atol=1e-5)
