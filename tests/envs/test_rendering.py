"""Pictures: of the right things, in the right places, as OGBench's."""

import ctypes.util

import numpy as np
import pytest

from pigbench.envs.rendering import Canvas, Renderer
from pigbench.errors import UserError

GOAL = np.array([[0.4, -0.15, 0.02], [0.4, 0.15, 0.06]])


@pytest.fixture(scope="module")
def renderer(drawing):
    with Renderer(2, width=320, height=240) as renderer:
        yield renderer


def test_same_state_same_picture(renderer, scene):
    qpos = scene(2).home_qpos
    first = renderer.draw(qpos)
    assert first.shape == (240, 320, 3)
    assert first.dtype == np.uint8
    renderer.draw(qpos, GOAL)
    np.testing.assert_array_equal(renderer.draw(qpos), first)


def where_red(picture: np.ndarray) -> np.ndarray:
    """Pixels of the red cube, (count, 2)."""
    red, green, blue = np.moveaxis(picture.astype(int), -1, 0)
    return np.argwhere((red > 150) & (green < 100) & (blue < 130))


def test_a_cube_is_drawn_where_it_lies(renderer, scene):
    """To the right of the picture is towards positive y, down is towards the camera."""
    centres = []
    for xy in ((0.35, -0.1), (0.35, 0.1), (0.5, 0.1)):
        qpos = scene(2).home_qpos.copy()
        qpos[scene(2).cubes_qpos][:2] = xy
        centres.append(where_red(renderer.draw(qpos)).mean(axis=0))
    (row, column), (row_right, column_right), (row_near, _) = centres
    assert abs(row - row_right) < 2
    assert abs((column + column_right) / 2 - 159.5) < 2
    assert column_right - column > 40
    assert row_near > row + 20


def test_goals_are_translucent(renderer, scene):
    qpos = scene(2).home_qpos
    without, shown = renderer.draw(qpos).astype(int), renderer.draw(qpos, GOAL).astype(int)
    change = np.abs(shown - without).max(axis=-1)
    assert 200 < np.sum(change > 20) < 4000
    assert len(where_red(shown)) == len(where_red(without))


def test_looks_as_ogbenchs_own_picture(renderer, ogbench_env):
    theirs = ogbench_env("cube-double", mode="task")
    theirs.reset(seed=3, options={"task_id": 4})
    theirs.model.vis.global_.offwidth, theirs.model.vis.global_.offheight = 320, 240
    canvas = Canvas(theirs.model, width=320, height=240)
    expected = canvas.draw(theirs.data).astype(int)
    canvas.close()
    ours = renderer.draw(theirs.data.qpos, theirs.data.mocap_pos).astype(int)
    different = np.abs(ours - expected).max(axis=-1) > 30
    assert different.mean() < 0.01


def test_nothing_to_draw_with(monkeypatch):
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setattr(ctypes.util, "find_library", lambda _: None)
    with pytest.raises(UserError, match="install EGL"):
        Renderer(1)
    monkeypatch.setenv("MUJOCO_GL", "nonsense")
    with pytest.raises(UserError, match=r"unknown value of MUJOCO_GL 'nonsense'.* known are egl"):
        Renderer(1)
