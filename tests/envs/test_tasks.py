"""Tasks, episode limits and names, equal to those `ogbench` registers."""

import dataclasses

import gymnasium
import numpy as np
import pytest

from pigbench import envs
from pigbench.envs import observation, workspace
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


PLACED = envs.Task("task1", start=((0.4, 0.1),), goal=((0.4, -0.1),))

HALF_INSIDE = (0.4, 0.0), (0.42, 0.02)
TOUCHING = (0.4, 0.0), (0.42, 0.04)


def placed(**changes: object) -> dict[str, tuple[envs.Task, ...]]:
    return {"tasks": (dataclasses.replace(PLACED, **changes),)}


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        (placed(start=((40.0, 10.0),)), r"a cube at \(40.0, 10.0\) in 'task1': a place is"),
        (placed(goal=((0.4,),)), r"a place is \(x, y\) in metres, x from 0.22 to 0.63"),
        (placed(goal=((0.4, float("nan")),)), "a place is"),
        (placed(goal=((0.4, 0.1, 0.5),)), "with a whole level"),
        (placed(jitter=(0.1, -0.1)), r"starts by up to \(0.1, -0.1\)"),
        (placed(name="a/b"), "a task is named 'a/b': choose"),
        ({"num_cubes": 2} | placed(start=HALF_INSIDE, goal=TOUCHING), r"cubes at \(0.4, 0.0\) and"),
        ({"tasks": (PLACED, PLACED)}, "two tasks named 'task1'"),
        ({"success_distance": 0.0}, "placed within 0.0 m: it must be more than 0"),
    ],
)
def test_what_is_wrong_with_an_environment_is_said(changes, says):
    with pytest.raises(UserError, match=says):
        dataclasses.replace(envs.SPECS["cube-single"], **changes)


def test_what_is_not_observed_must_be_known():
    with pytest.raises(UserError, match="unknown observation 'efector_pos': did you mean"):
        observation.layout(1, {"efector_pos"})
