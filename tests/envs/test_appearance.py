"""What is drawn stands where the physics has it, and looks as in OGBench."""

import mujoco
import numpy as np
import pytest

from pigbench.envs import appearance
from pigbench.envs.cubes import MAX_CUBES


@pytest.fixture(params=["meshes", "capsules"])
def build(request, monkeypatch):
    if request.param == "capsules":
        monkeypatch.setattr(appearance, "mesh_folder", lambda: None)
    return lambda num_cubes: appearance.build(num_cubes, width=64, height=48)


@pytest.mark.parametrize("num_cubes", [1, 8, 12])
def test_stands_where_the_physics_has_it(build, scene, num_cubes):
    model, physics = build(num_cubes), scene(num_cubes).model
    assert (model.nq, model.nv) == (physics.nq, physics.nv)
    qpos = scene(num_cubes).home_qpos + 0.1
    drawn, simulated = mujoco.MjData(model), mujoco.MjData(physics)
    for data, owner in ((drawn, model), (simulated, physics)):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(owner, data)
    names = [physics.body(index).name for index in range(physics.nbody)]
    assert "cube_0" in names
    for name in names:
        np.testing.assert_allclose(drawn.body(name).xpos, simulated.body(name).xpos, atol=1e-9)


def test_goals_are_mocap_bodies_in_order(build):
    model = build(4)
    assert model.nmocap == 4
    for index in range(4):
        assert model.body(f"goal_{index}").mocapid[0] == index
        goal = model.geom(model.body(f"goal_{index}").geomadr[0])
        np.testing.assert_allclose(goal.size, 0.02)
        np.testing.assert_allclose(goal.rgba[:3], model.geom(f"cube_{index}").rgba[:3])
        assert goal.rgba[3] < 1


def test_every_cube_has_a_colour_of_its_own():
    colors = np.array([appearance.cube_color(index) for index in range(MAX_CUBES)])
    assert np.all((colors >= 0) & (colors <= 1))
    apart = np.linalg.norm(colors[:, None] - colors, axis=-1) + np.eye(MAX_CUBES)
    assert apart.min() > 0.1


def test_colours_lights_and_view_are_ogbenchs(ogbench_env):
    theirs = ogbench_env("cube-octuple", mode="task")
    ours = appearance.build(8, width=64, height=48)
    np.testing.assert_allclose(appearance.CUBE_COLORS, theirs._cube_colors[:, :3])
    lamp, other = ours.vis.headlight, theirs.model.vis.headlight
    for field in ("ambient", "diffuse", "specular"):
        np.testing.assert_allclose(getattr(lamp, field), getattr(other, field))
    np.testing.assert_allclose(ours.stat.center, theirs.model.stat.center)
    assert ours.stat.extent == theirs.model.stat.extent
    for field in ("azimuth", "elevation", "fovy"):
        assert getattr(ours.vis.global_, field) == getattr(theirs.model.vis.global_, field)


def test_meshes_are_in_ogbenchs_places(ogbench_env):
    """Every mesh that OGBench shows is at the same place on a body at the same place."""
    theirs = ogbench_env("cube-single")
    model, qpos = appearance.build(1, width=64, height=48), theirs.data.qpos
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)

    def seen(model, data) -> np.ndarray:
        meshes = np.flatnonzero(
            (model.geom_type == mujoco.mjtGeom.mjGEOM_MESH) & (model.geom_group < 3)
        )
        places = np.c_[data.geom_xpos, data.geom_xmat, model.geom_rgba][meshes]
        return places[np.lexsort(np.round(places, 4).T)]

    def colored(model) -> None:
        """Materials' colours where geoms themselves have none."""
        has = model.geom_matid >= 0
        model.geom_rgba[has] = model.mat_rgba[model.geom_matid[has]]

    reference = mujoco.MjData(theirs.model)
    reference.qpos[:] = qpos
    mujoco.mj_forward(theirs.model, reference)
    before = theirs.model.geom_rgba.copy()
    colored(theirs.model)
    expected = seen(theirs.model, reference)
    theirs.model.geom_rgba[:] = before
    assert len(expected) > 30
    np.testing.assert_allclose(seen(model, data), expected, atol=1e-4)
