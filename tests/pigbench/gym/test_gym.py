"""The environments through Gymnasium, driven as OGBench's own."""

import subprocess
import sys

import gymnasium
import numpy as np
import ogbench  # noqa: F401  registers its environments
import pytest
from flax import struct
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import pigbench  # noqa: F401  registers its environments
from pigbench.errors import UserError

OURS, THEIRS = "pigbench/cube-single-v0", "cube-single-v0"


@pytest.fixture(scope="module")
def single():
    with gymnasium.make(OURS) as env:
        yield env


@pytest.fixture(scope="module")
def batch():
    env = gymnasium.make_vec(OURS, num_envs=3, max_episode_steps=4)
    yield env
    env.close()


def evaluate(env, act, *, steps):
    """An episode of every task, by its name, in the habit of OGBench's evaluation."""
    tasks = env.unwrapped.task_infos
    for task in range(1, len(tasks) + 1):
        observation, info = env.reset(seed=0, options={"task_id": task, "render_goal": False})
        goal, done, trajectory = info["goal"], False, [observation]
        while not done and len(trajectory) <= steps:
            action = np.clip(act(observation, goal), -1, 1)
            observation, _, terminated, truncated, info = env.step(action)
            done = terminated or truncated
            trajectory.append(observation)
        name = tasks[task - 1]["task_name"]
        yield name, goal.shape, np.array(trajectory).shape, bool(info["success"]), done


def test_one_function_drives_ours_and_ogbenchs(single):
    def act(observation, goal):
        """Towards the goal's cube, and down."""
        return np.concatenate([goal[19:21] - observation[12:14], [-0.1, 0, 0.5]])

    with gymnasium.make(THEIRS) as theirs:
        results = list(evaluate(single, act, steps=3))
        assert results == list(evaluate(theirs, act, steps=3))
        assert results[1] == ("task2_vertical1", (28,), (4, 28), False, False)
        assert single.unwrapped.num_tasks == theirs.unwrapped.num_tasks == len(results)
        for ours, their in zip(
            single.unwrapped.task_infos, theirs.unwrapped.task_infos, strict=True
        ):
            assert ours.keys() == their.keys()
            for positions in ("init_xyzs", "goal_xyzs"):
                np.testing.assert_allclose(ours[positions], their[positions])
        assert single.action_space.shape == theirs.action_space.shape
        assert single.observation_space.shape == theirs.observation_space.shape
        assert single.spec.max_episode_steps == theirs.spec.max_episode_steps


def test_gymnasiums_own_checker_passes(single):
    check_env(single.unwrapped, skip_render_check=True)


def test_a_task_is_that_of_the_options(single):
    goals = [single.reset(options={"task_id": task})[1] for task in (1, 5)]
    assert [info["task_id"] for info in goals] == [1, 5]
    for task in (0, 6):
        with pytest.raises(UserError, match=f"task_id is {task}: cube-single has tasks 1 to 5"):
            single.reset(options={"task_id": task})


@pytest.mark.parametrize("task", [None, 2.5, "1", True, [1, 2]])
def test_what_is_no_task_is_said(single, task):
    with pytest.raises(UserError, match="cube-single has tasks 1 to 5"):
        single.reset(options={"task_id": task})


def test_an_action_of_another_size_is_said(single, batch):
    single.reset(seed=0)
    with pytest.raises(UserError, match=r"\(1, 4\): it must be \(1, 5\)"):
        single.unwrapped.step(np.zeros(4))
    batch.reset(seed=0)
    with pytest.raises(UserError, match=r"\(5,\): it must be \(3, 5\)"):
        batch.step(np.zeros(5))


@pytest.mark.parametrize(
    ("asked", "complaint"),
    [
        ({"seed": [0, 1, 2]}, "one integer for all"),
        ({"options": {"task_id": [1, 2]}}, "tasks 1 to 5"),
        ({"options": {"reset_mask": np.ones(2, bool)}}, r"bool of shape \(2,\)"),
        ({"options": {"reset_mask": np.ones(3, int)}}, r"int64 of .* must be bool of shape \(3,\)"),
    ],
)
def test_a_batch_says_what_it_cannot_reset(batch, asked, complaint):
    with pytest.raises(UserError, match=complaint):
        batch.reset(**asked)


def test_success_ends_an_episode_with_a_reward(single):
    single.reset(seed=1)
    env = single.unwrapped
    physics = env._states.pipeline_state
    cubes = physics.qpos[:, env._simulation.env.scene.cubes_qpos].reshape(1, 1, 7)[..., :3]
    env._states = struct.dataclasses.replace(env._states, info=env._states.info | {"target": cubes})
    _, reward, terminated, truncated, info = single.step(np.zeros(5, np.float32))
    assert (reward, terminated, truncated, info["success"]) == (1.0, True, False, True)


def test_goals_can_be_told_as_cube_positions(single):
    with (
        gymnasium.make(OURS, goals="cubes") as told,
        gymnasium.make(THEIRS, use_oracle_rep=True) as theirs,
    ):
        goal = told.reset(seed=3, options={"task_id": 1})[1]["goal"]
        np.testing.assert_array_equal(
            goal, single.reset(seed=3, options={"task_id": 1})[1]["goal"][19:22]
        )
        expected = theirs.reset(seed=3, options={"task_id": 1})[1]["goal"]
        np.testing.assert_allclose(goal, expected, atol=0.02)  # millimetres, after two random steps


@pytest.mark.parametrize("name", ["task", "renders_goal"])
def test_an_option_that_reset_has_not_is_said(single, batch, name):
    for env in (single, batch):
        with pytest.raises(UserError, match=f"unknown option of reset '{name}': did you mean"):
            env.reset(options={name: 1})


def test_unknown_goals_are_refused_by_their_name():
    with pytest.raises(UserError, match="unknown goals 'cube': did you mean 'cubes'"):
        gymnasium.make(OURS, goals="cube")


def test_a_batch_is_as_many_environments(batch, single):
    assert batch.metadata["autoreset_mode"] is AutoresetMode.DISABLED
    observations, info = batch.reset(seed=0, options={"task_id": [1, 2, 3]})
    assert batch.observation_space.contains(observations)
    assert info["task_id"].tolist() == [1, 2, 3]
    assert info["goal"].shape == (3, 28)
    again, _ = batch.reset(seed=0, options={"task_id": [1, 2, 3]})
    np.testing.assert_array_equal(observations, again)
    assert batch.single_observation_space == single.observation_space


def test_a_batchs_episodes_end_apart_and_stay(batch):
    batch.reset(seed=0)
    actions = np.zeros((3, 5), np.float32)
    for _ in range(2):
        batch.step(actions)
    batch.reset(options={"reset_mask": np.array([False, True, False])})
    for expected in ([False] * 3, [True, False, True]):
        observations, rewards, terminated, truncated, _ = batch.step(actions)
        assert truncated.tolist() == expected
        assert not terminated.any()
        assert not rewards.any()
    later, *_ = batch.step(np.ones((3, 5), np.float32))
    np.testing.assert_array_equal(later[[0, 2]], observations[[0, 2]])
    assert np.any(later[1] != observations[1])


def test_pictures_of_a_state_and_of_its_goal():
    with gymnasium.make(OURS, render_mode="rgb_array") as env:
        _, info = env.reset(seed=0, options={"task_id": 1, "render_goal": True})
        picture = env.render()
        assert picture.shape == info["goal_rendered"].shape == (200, 200, 3)
        assert np.any(picture != info["goal_rendered"])


def test_a_batch_draws_all_its_goals():
    with gymnasium.make(OURS) as env:
        _, expected = env.reset(seed=0, options={"task_id": 1, "render_goal": True})
    env = gymnasium.make_vec(OURS, num_envs=2)
    _, info = env.reset(seed=0, options={"task_id": [1, 5], "render_goal": True})
    env.close()
    first, second = info["goal_rendered"]
    assert first.shape == expected["goal_rendered"].shape
    assert np.any(first != second)
    assert info["_goal_rendered"].tolist() == [True, True]


@pytest.mark.parametrize(
    ("asked", "complaint"),
    [
        ({"num_envs": 0}, "num_envs is 0: it must be at least 1"),
        ({"max_episode_steps": 0}, "max_episode_steps is 0: it must be at least 1, or -1"),
        ({"max_episode_steps": -2}, "max_episode_steps is -2: it must be"),
    ],
)
def test_a_batch_that_cannot_be_is_said(asked, complaint):
    with pytest.raises(UserError, match=complaint):
        gymnasium.make_vec(OURS, **asked)


def test_a_time_limit_of_minus_one_is_none():
    env = gymnasium.make_vec(OURS, num_envs=1, max_episode_steps=-1)
    before, _ = env.reset(seed=0)
    after, _, _, truncated, _ = env.step(np.ones((1, 5), np.float32))
    env.close()
    assert not truncated[0]
    assert np.any(after != before)


@pytest.mark.filterwarnings("ignore:.*initialised with render_mode='ansi'")
def test_what_cannot_be_is_said():
    with pytest.raises(UserError, match="render_mode is 'ansi': it must be None or 'rgb_array'"):
        gymnasium.make(OURS, render_mode="ansi", disable_env_checker=True)


def test_importing_pigbench_leaves_jax_alone():
    code = "import pigbench, sys; assert not {'jax', 'brax'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
