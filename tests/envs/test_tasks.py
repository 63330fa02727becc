"""Tasks, episode limits and names, equal to those `ogbench` registers."""

import dataclasses

import gymnasium
import numpy as np
import pytest

from pigbench import envs
from pigbench.envs import workspace
from pigbench.envs.tasks import TASKS
from pigbench.errors import UserError

OGBENCH = [name for name, spec in envs.SPECS.items() if spec.reality is None]


@pytest.mark.parametrize("name", OGBENCH)
def test_tasks(ogbench_env, name):
    theirs = ogbench_env(name, "task").task_infos
    assert [task.name for task in TASKS[name]] == [info["task_name"] for info in theirs]
    for task, info in zip(TASKS[name], theirs, strict=True):
        np.testing.assert_allclose(task.start_xyz, info["init_xyzs"], atol=1e-12, err_msg=task.name)
        np.testing.assert_allclose(task.goal_xyz, info["goal_xyzs"], atol=1e-12, err_msg=task.name)


@pytest.mark.parametrize("name", OGBENCH)
def test_limits_and_sizes(ogbench_env, name):
    spec = envs.SPECS[name]
    assert spec.episode_length == gymnasium.spec(f"{name}-v0").max_episode_steps
    assert spec.num_cubes == ogbench_env(name, "task")._num_cubes
    assert spec.tasks is TASKS[name]


def test_every_cube_environment_of_ogbench_is_here():
    registered = {
        spec.removesuffix("-v0")
        for spec in gymnasium.registry
        if spec.startswith("cube-") and "singletask" not in spec
    }
    assert set(OGBENCH) == registered


def test_the_robot_starts_from_all_of_the_table_and_ends_at_its_centre():
    spec = envs.SPECS["cube-centre"]
    (task,) = spec.tasks
    low, high = np.array(workspace.CUBE.low), np.array(workspace.CUBE.high)
    start = task.start_xyz[0, :2]
    np.testing.assert_allclose([start - task.jitter, start + task.jitter], [low, high])
    np.testing.assert_allclose(task.goal_xyz[0, :2], (low + high) / 2)


def test_an_environment_of_ones_own_has_a_name_of_its_own(monkeypatch):
    monkeypatch.setattr(envs, "SPECS", dict(envs.SPECS))
    spec = dataclasses.replace(envs.SPECS["cube-single"], name="mine")
    envs.register(spec)
    assert envs.names()[-1] == "mine"
    with pytest.raises(UserError, match="environment 'mine' is already registered"):
        envs.register(spec)
    with pytest.raises(UserError, match="an environment is named 'a/b'"):
        envs.register(dataclasses.replace(spec, name="a/b"))
