"""Tasks, episode limits and names, equal to those `ogbench` registers."""

import dataclasses

import gymnasium
import mujoco
import numpy as np
import ogbench  # noqa: F401  registers its environments
import pytest

from pigbench import envs
from pigbench.envs import terms, workspace
from pigbench.envs.tasks import TASKS
from pigbench.errors import UserError

OGBENCH = sorted(
    name.removesuffix("-v0")
    for name in gymnasium.registry
    if name.startswith("cube-") and "singletask" not in name
)


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
    assert len(OGBENCH) == 5
    assert set(OGBENCH) <= set(envs.SPECS)


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
APART = (0.4, -0.05), (0.42, 0.05)


def placed(**changes: object) -> dict[str, tuple[envs.Task, ...]]:
    return {"tasks": (dataclasses.replace(PLACED, **changes),)}


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        (placed(start=((40.0, 10.0),)), r"a cube at \(40.0, 10.0\) in 'task1': a place is"),
        (placed(goal=((0.4,),)), r"a place is \(x, y\) in metres, x from 0.243 to 0.607"),
        (placed(goal=((0.22, 0.38),)), r"a cube at \(0.22, 0.38\) in 'task1'"),
        (placed(goal=((0.4, float("nan")),)), "a place is"),
        (placed(goal=((0.4, 0.1, 0.5),)), "with a whole level"),
        (placed(jitter=(0.1, -0.1)), r"starts by up to \(0.1, -0.1\)"),
        (placed(jitter=(10.0, 10.0)), r"by up to \(10.0, 10.0\) in 'task1', which takes that at"),
        (placed(start=((0.25, 0.1),)), r"that at \(0.25, 0.1\) off the table: a cube's place is x"),
        (placed(name="a/b"), "a task is named 'a/b': choose"),
        ({"num_cubes": 2} | placed(start=HALF_INSIDE, goal=TOUCHING), r"cubes at \(0.4, 0.0\) and"),
        (
            {"num_cubes": 2} | placed(start=APART, goal=APART, jitter=(0.0, 0.04)),
            r"so that cubes at \(0.4, -0.05\) and at \(0.42, 0.05\) may overlap: shift them less",
        ),
        ({"policy": "nope"}, "unknown policy 'nope': .*known are noisy, play, replan"),
        ({"unobserved": {"efector_pos"}}, "unknown observation 'efector_pos': did you mean"),
        ({"unobserved": {*terms.layout(1)}}, "observes nothing"),
        ({"tasks": (PLACED, PLACED)}, "two tasks named 'task1'"),
        ({"success_distance": 0.0}, "placed within 0.0 m: it must be more than 0"),
    ],
)
def test_what_is_wrong_with_an_environment_is_said(changes, says):
    with pytest.raises(UserError, match=says):
        dataclasses.replace(envs.SPECS["cube-single"], **changes)


@pytest.mark.parametrize("jitter", [(0.029, 0.029), (0.3 / 4, 0.029), (0.02, 0.05)])
def test_cubes_may_be_shifted_until_they_touch(jitter):
    """Whichever of the corners of their shifts they are at."""
    x, y = jitter
    corners = [(0.425 + sx * x, sy * y) for sx in (-1, 1) for sy in (-1, 1)]
    others = [(0.425 + sx * x, 0.1 + sy * y) for sx in (-1, 1) for sy in (-1, 1)]
    changes = placed(start=((0.425, 0.0), (0.425, 0.1)), goal=APART, jitter=jitter)
    apart = min(max(abs(a - c), abs(b - d)) for a, b in corners for c, d in others)
    if apart > 2 * 0.02:
        dataclasses.replace(envs.SPECS["cube-single"], num_cubes=2, **changes)
    else:
        with pytest.raises(UserError, match="may overlap"):
            dataclasses.replace(envs.SPECS["cube-single"], num_cubes=2, **changes)


@pytest.mark.parametrize(("axis", "towards"), [(0, -1), (0, 1), (1, -1), (1, 1)])
def test_places_reach_as_far_as_a_cube_in_the_compiled_scene(scene, axis, towards):
    """A tenth of a millimetre farther than the last accepted place, it touches a wall."""
    model = scene(1).model
    data = mujoco.MjData(model)

    def touches_a_wall(place: tuple[float, float]) -> bool:
        data.qpos[:] = scene(1).home_qpos
        data.qpos[scene(1).cubes_qpos][:2] = place
        mujoco.mj_forward(model, data)
        touching = [model.geom(i).name for contact in data.contact for i in contact.geom]
        return any("wall" in name for name in touching)

    def is_accepted(place: tuple[float, float]) -> bool:
        try:
            dataclasses.replace(envs.SPECS["cube-single"], **placed(goal=(place,)))
        except UserError:
            return False
        return True

    way = towards * np.eye(2)[axis]
    places = [tuple(np.array([0.425, 0.0]) + far * way) for far in np.linspace(0, 0.4, 4001)]
    first_refused = [is_accepted(place) for place in places].index(False)
    first_touching = [touches_a_wall(place) for place in places].index(True)
    assert abs(first_refused - first_touching) <= 1
