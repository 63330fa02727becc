"""The appearance of the scene: colours, lights, goal cubes and the shape of the robot.

If the `ogbench` package is installed, the robot is drawn with the meshes in it; otherwise, its
links are drawn as capsules.
"""

# mujoco's compiled modules have no types.
# pyright: reportAttributeAccessIssue=false

import colorsys
import importlib.util
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np

from pigbench.envs import robot, scene
from pigbench.envs.cubes import CUBE_HALF_SIZE
from pigbench.envs.walls import WALLS

# Colours are red, green, blue; cubes, floor and lights are as in OGBench's pictures.
CUBE_COLORS = (
    (0.96, 0.26, 0.33),
    (0.35, 0.55, 0.91),
    (1.0, 0.69, 0.21),
    (0.06, 0.74, 0.21),
    (0.61, 0.28, 0.82),
    (0.76, 0.96, 0.04),
    (0.82, 0.28, 0.61),
    (0.5, 0.5, 0.5),
)
_GOLDEN_RATIO = (5**0.5 - 1) / 2  # multiples of it, modulo 1, keep apart
GOAL_OPACITY = 0.2
CAPSULE_COLOR = (0.6, 0.72, 0.94)
FLOOR_COLORS = (0.08, 0.11, 0.16), (0.15, 0.18, 0.25)
FLOOR_MARK = (0.8, 0.8, 0.8)
SKY_COLORS = (0.15, 0.18, 0.25), (0.0, 0.0, 0.0)
NOWHERE = (0.0, 0.0, -1.0)  # under the floor, where a goal cube is invisible

HIDDEN, SHOWN = 3, 1  # geom groups: MuJoCo draws those up to 2
_ARM_RADIUS, _FINGER_RADIUS = 0.045, 0.006  # metres


class Meshes(NamedTuple):
    """A robot description in the `ogbench` package, and its body names that differ from ours."""

    file: str
    renamed: dict[str, str]


MESHES = (
    Meshes(
        "universal_robots_ur5e/ur5e.xml",
        {f"{name}_link": name for name in ("shoulder", "upper_arm", "forearm")}
        | {f"wrist_{i}_link": f"wrist_{i}" for i in (1, 2, 3)},
    ),
    Meshes(
        "robotiq_2f85/2f85.xml",
        {"base_mount": "gripper_mount", "base": "gripper_base"}
        | {f"{side}_silicone_pad": f"{side}_silicone" for side in ("right", "left")},
    ),
)


def mesh_folder() -> Path | None:
    """The folder of robot descriptions in the `ogbench` package; None if it is not installed."""
    package = importlib.util.find_spec("ogbench")
    if package is None or not package.submodule_search_locations:
        return None
    return Path(package.submodule_search_locations[0]) / "manipspace" / "descriptions"


def build(num_cubes: int, *, width: int, height: int) -> mujoco.MjModel:
    """The model for rendering, at up to `width` by `height` pixels.

    Its qpos is the scene's; its mocap bodies are the cubes' goals, in order.
    """
    spec = scene.describe(num_cubes, "exact")
    _set_view(spec, width, height)
    _set_light(spec)
    _color_floor(spec)
    for unseen in (*spec.sites, *(spec.geom(name) for name in WALLS)):
        unseen.group = HIDDEN
    for index in range(num_cubes):
        _color_cube(spec, index)
    folder = mesh_folder()
    if folder is None:
        _add_capsules(spec)
    else:
        for description in MESHES:
            _add_meshes(spec, folder, description)
        _hide_boxes(spec)
    return spec.compile()


def _set_view(spec: mujoco.MjSpec, width: int, height: int) -> None:
    """The free camera's pose, which follows from the scene's centre and extent."""
    view = spec.visual.global_
    view.offwidth, view.offheight = width, height
    view.azimuth, view.elevation = 180, -20
    spec.stat.center = (0.3, 0.0, 0.15)
    spec.stat.extent = 0.7
    spec.stat.meansize = 0.04
    spec.visual.map.znear, spec.visual.map.zfar = 0.1, 10.0


def _set_light(spec: mujoco.MjSpec) -> None:
    lamp = spec.visual.headlight
    lamp.diffuse, lamp.ambient, lamp.specular = (0.6,) * 3, (0.1,) * 3, (0,) * 3
    sun = spec.worldbody.add_light(name="sun", pos=(0, 0, 2), dir=(0, 0, -1))
    sun.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    spot = spec.worldbody.add_light(name="spot", pos=(0.25, 0, 0.5), dir=(0, 0, -1))
    spot.type = mujoco.mjtLightType.mjLIGHT_SPOT
    spot.cutoff, spot.castshadow, spot.diffuse = 100, False, (0.3,) * 3


def _color_floor(spec: mujoco.MjSpec) -> None:
    spec.add_texture(
        name="floor",
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=FLOOR_COLORS[0],
        rgb2=FLOOR_COLORS[1],
        mark=mujoco.mjtMark.mjMARK_CROSS,
        markrgb=FLOOR_MARK,
        width=512,
        height=512,
    )
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=SKY_COLORS[0],
        rgb2=SKY_COLORS[1],
        width=512,
        height=512,
    )
    material = spec.add_material(name="floor", texuniform=True)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "floor"
    spec.geom("floor").material = "floor"


def cube_color(index: int) -> tuple[float, float, float]:
    """The colour of a cube: OGBench's, and then hues that are far from each other."""
    if index < len(CUBE_COLORS):
        return CUBE_COLORS[index]
    return colorsys.hsv_to_rgb(index * _GOLDEN_RATIO % 1, 0.5, 0.7)


def _color_cube(spec: mujoco.MjSpec, index: int) -> None:
    color = cube_color(index)
    spec.geom(f"cube_{index}").rgba = (*color, 1.0)
    goal = spec.worldbody.add_body(name=f"goal_{index}", mocap=True, pos=NOWHERE)
    _add_shape(goal, mujoco.mjtGeom.mjGEOM_BOX, (*color, GOAL_OPACITY), size=(CUBE_HALF_SIZE,) * 3)


def _add_capsules(spec: mujoco.MjSpec) -> None:
    """Add a capsule from each link's origin to that of the next."""
    arm = {link.name for link in robot.ARM}
    for link in robot.LINKS:
        if link.parent != "world" and any(link.pos):
            radius = _ARM_RADIUS if link.name in arm else _FINGER_RADIUS
            _add_shape(
                spec.body(link.parent),
                mujoco.mjtGeom.mjGEOM_CAPSULE,
                (*CAPSULE_COLOR, 1.0),
                size=(radius, 0, 0),
                fromto=(0, 0, 0, *link.pos),
            )


def _add_meshes(spec: mujoco.MjSpec, folder: Path, description: Meshes) -> None:
    """Add the visible meshes of a description to our bodies, whose frames are the same."""
    source = mujoco.MjSpec.from_file(str(folder / description.file))
    prefix = Path(description.file).stem
    files = Path(source.modelfiledir) / source.meshdir
    for mesh in source.meshes:
        spec.add_mesh(name=f"{prefix}_{mesh.name}", file=str(files / mesh.file), scale=mesh.scale)
    for body in source.bodies:
        for geom in body.geoms:
            if geom.material:
                material = source.material(geom.material)
                _add_shape(
                    spec.body(description.renamed.get(body.name, body.name)),
                    mujoco.mjtGeom.mjGEOM_MESH,
                    material.rgba,
                    meshname=f"{prefix}_{geom.meshname}",
                )


def _hide_boxes(spec: mujoco.MjSpec) -> None:
    """Hide the gripper's collision boxes, which the meshes replace."""
    for name in ("right_pad", "left_pad", *(box.link for box in scene.LINK_BOXES)):
        for geom in spec.body(name).geoms:
            if geom.type == mujoco.mjtGeom.mjGEOM_BOX:
                geom.group = HIDDEN


def _add_shape(
    body: mujoco.MjsBody, kind: mujoco.mjtGeom, rgba: Sequence[float] | np.ndarray, **shape: Any
) -> None:
    """Add a purely visual geom, which collides with nothing."""
    body.add_geom(type=kind, rgba=rgba, contype=0, conaffinity=0, group=SHOWN, mass=0, **shape)
