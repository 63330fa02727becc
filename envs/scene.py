"""The MuJoCo model of robot, floor, walls and cubes, and the layout of its state vectors.

Explicit contact pairs are those that occur in OGBench's own play data: pads, cubes, floor, walls
and, where a grasp goes wrong, links of the gripper. The scene has two profiles: `exact` gives each
finger OGBench's two pad boxes, and `fast` gives it one.
"""

# mujoco's compiled modules have no types.
# pyright: reportAttributeAccessIssue=false

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import Any

import mujoco
import numpy as np
from jaxtyping import Float, Int

from pigbench.envs import robot
from pigbench.envs.cubes import CUBE_DENSITY, CUBE_HALF_SIZE
from pigbench.envs.units import CONTROL_STEP
from pigbench.envs.walls import WALLS
from pigbench.errors import lookup

PHYSICS_STEP = 0.002
SUBSTEPS = round(CONTROL_STEP / PHYSICS_STEP)


@dataclass(frozen=True)
class PadBox:
    """A box of a finger pad: half sizes, centre in the pad's frame, sliding friction."""

    half_size: robot.Vector
    pos: robot.Vector
    friction: float


@dataclass(frozen=True)
class LinkBox:
    """A box of a link of the gripper: half sizes, centre in the link's frame, tilt about its x."""

    link: str
    half_size: robot.Vector
    pos: robot.Vector
    tilt: float = 0.0  # radians


# Each shares one face with OGBench's mesh, the one that cubes can reach.
LINK_BOXES = (
    LinkBox("gripper_base", (0.01, 0.0155, 0.01), (0.0, 0.0, 0.08)),
    *(
        replace(box, link=f"{side}_{box.link}")
        for side in ("right", "left")
        for box in (
            LinkBox("spring_link", (0.014, 0.006, 0.0286), (0.0, 0.01865, 0.02168), -0.7108),
            LinkBox("follower", (0.007, 0.00275, 0.0233), (0.0, -0.00662, 0.02213), 0.4313),
        )
    ),
)

# Profile -> the boxes of one finger's pad.
PROFILES = {
    "exact": (
        PadBox((0.011, 0.004, 0.009375), (0, -0.0026, 0.028125), 0.7),
        PadBox((0.011, 0.004, 0.009375), (0, -0.0026, 0.009375), 0.6),
    ),
    "fast": (PadBox((0.011, 0.004, 0.01875), (0, -0.0026, 0.01875), 0.7),),
}


@dataclass(frozen=True)
class Contact:
    """Contact parameters of a pair of geoms: softness, impedance and sliding friction."""

    solref: robot.Vector
    solimp: robot.Vector
    friction: float


_ROW = 8  # cubes side by side between the walls, where they are at home
_TORSION, _ROLLING = 0.005, 0.0001
# Contact time constants: of cubes and pads, and of the floor.
_STIFF, _SOFT = 0.004, robot.DEFAULT_SOLREF[0]
CUBE_CUBE = Contact((_STIFF, 1.0), robot.DEFAULT_SOLIMP, 1.0)
# MuJoCo averages the time constants of the two.
CUBE_OTHER = Contact(((_STIFF + _SOFT) / 2, 1.0), robot.DEFAULT_SOLIMP, 1.0)


def _pad_contact(friction: float) -> Contact:
    """The contact of a pad, whose own softness and friction take priority over the other geom's."""
    return Contact((_STIFF, 1.0), robot.STIFF_SOLIMP, friction)


@dataclass(frozen=True)
class Scene:
    """A compiled model and the slices of its parts.

    qpos is [arm 6, gripper 8, then position 3 and quaternion 4 per cube]; qvel is [arm 6,
    gripper 8, then linear 3 and angular 3 per cube]; ctrl is [arm 6, gripper 1].
    """

    model: mujoco.MjModel
    num_cubes: int
    profile: str

    arm = slice(0, len(robot.ARM_JOINTS))
    gripper = slice(len(robot.ARM_JOINTS), len(robot.ARM_JOINTS) + len(robot.GRIPPER_JOINTS))
    driver = len(robot.ARM_JOINTS) + robot.GRIPPER_JOINTS.index("right_driver")

    @property
    def cubes_qpos(self) -> slice:
        """The cubes' slice of qpos: num_cubes blocks of position 3 and quaternion 4."""
        return slice(self.gripper.stop, self.gripper.stop + 7 * self.num_cubes)

    @property
    def cubes_qvel(self) -> slice:
        """The cubes' slice of qvel: num_cubes blocks of linear 3 and angular 3."""
        return slice(self.gripper.stop, self.gripper.stop + 6 * self.num_cubes)

    @cached_property
    def cube_bodies(self) -> Int[np.ndarray, "cube"]:
        """The body ids of the cubes."""
        return np.array([self.model.body(f"cube_{i}").id for i in range(self.num_cubes)])

    @cached_property
    def home_qpos(self) -> Float[np.ndarray, "nq"]:
        """The qpos with the arm at home, the gripper open and the cubes in rows."""
        qpos = self.model.qpos0.copy()
        qpos[self.arm] = robot.HOME
        return qpos


def build(num_cubes: int, profile: str = "exact") -> Scene:
    """Compile the scene with `num_cubes` cubes; `UserError` if `profile` is not in PROFILES."""
    return Scene(describe(num_cubes, profile).compile(), num_cubes, profile)


def describe(num_cubes: int, profile: str) -> mujoco.MjSpec:
    """The specification that `build` compiles."""
    pad_boxes = lookup("physics profile", PROFILES, profile)
    spec = mujoco.MjSpec()
    spec.modelname = f"pigbench_{num_cubes}_cubes_{profile}"
    spec.compiler.degree = False
    option = spec.option
    option.timestep = PHYSICS_STEP
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = 10.0

    _add_statics(spec)
    _add_robot(spec, pad_boxes)
    cubes = [_add_cube(spec, i, num_cubes) for i in range(num_cubes)]
    _add_contacts(spec, cubes, pad_boxes)
    return spec


def _add_statics(spec: mujoco.MjSpec) -> None:
    spec.worldbody.add_geom(
        name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=(1, 1, 0.01), contype=0, conaffinity=0
    )
    for name, (half_size, pos) in WALLS.items():
        _add_box(spec.worldbody, name, half_size, pos)


def _add_box(
    body: mujoco.MjsBody,
    name: str,
    half_size: robot.Vector,
    pos: robot.Vector = (0, 0, 0),
    **inertia: float | robot.Vector,
) -> None:
    body.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=half_size,
        pos=pos,
        contype=0,
        conaffinity=0,
        **inertia,
    )


def _add_robot(spec: mujoco.MjSpec, pad_boxes: tuple[PadBox, ...]) -> None:
    bodies = {"world": spec.worldbody}
    for link in robot.LINKS:
        body = bodies[link.parent].add_body(
            name=link.name,
            pos=link.pos,
            quat=link.quat,
            mass=link.mass,
            ipos=link.com,
            iquat=link.inertia_quat,
            inertia=link.inertia,
            explicitinertial=True,
        )
        bodies[link.name] = body
        if link.joint:
            _add_joint(body, link.joint)
    bodies["gripper_base"].add_site(name="pinch", pos=(0, 0, robot.PINCH_HEIGHT))
    for side in ("right", "left"):
        pad = bodies[f"{side}_pad"]
        for i, box in enumerate(pad_boxes):
            _add_box(pad, f"{side}_pad_{i}", box.half_size, box.pos)
        _close_linkage(spec, side)
    for box in LINK_BOXES:
        quat = (math.cos(box.tilt / 2), math.sin(box.tilt / 2), 0, 0)
        _add_box(bodies[box.link], f"{box.link}_box", box.half_size, box.pos, quat=quat)
    _couple_drivers(spec)
    _add_contact_sensor(spec, bodies["right_pad"])
    _add_servos(spec)


def _add_joint(body: mujoco.MjsBody, joint: robot.Joint) -> None:
    element = body.add_joint(
        name=joint.name,
        type=mujoco.mjtJoint.mjJNT_HINGE,
        axis=joint.axis,
        pos=joint.anchor,
        range=joint.limits,
        limited=True,
        armature=joint.armature,
        springref=joint.spring_reference,
    )
    element.damping[0] = joint.damping
    element.stiffness[0] = joint.stiffness
    element.solref_limit[:2] = joint.limit_solref
    element.solimp_limit[:3] = joint.limit_solimp


def _stiff_equality(spec: mujoco.MjSpec, **what: Any) -> None:
    equality = spec.add_equality(**what)
    equality.solref[:2] = robot.STIFF_SOLREF
    equality.solimp[:3] = robot.STIFF_SOLIMP


def _close_linkage(spec: mujoco.MjSpec, side: str) -> None:
    _stiff_equality(
        spec,
        type=mujoco.mjtEq.mjEQ_CONNECT,
        name1=f"{side}_follower",
        name2=f"{side}_coupler",
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        data=[0] * 12,
    )


def _couple_drivers(spec: mujoco.MjSpec) -> None:
    _stiff_equality(
        spec,
        type=mujoco.mjtEq.mjEQ_JOINT,
        name1="right_driver",
        name2="left_driver",
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        data=[0, 1, *[0] * 10],
    )


def _add_contact_sensor(spec: mujoco.MjSpec, pad: mujoco.MjsBody) -> None:
    """Add a force sensor, which makes every engine compute the bodies' contact wrenches."""
    pad.add_site(name="right_pad")
    spec.add_sensor(
        name="right_pad",
        type=mujoco.mjtSensor.mjSENS_FORCE,
        objtype=mujoco.mjtObj.mjOBJ_SITE,
        objname="right_pad",
    )


def _add_servos(spec: mujoco.MjSpec) -> None:
    for servo in robot.ARM_SERVOS:
        _add_servo(
            spec,
            servo.joint,
            mujoco.mjtTrn.mjTRN_JOINT,
            servo.gain,
            servo.gain,
            servo.damping,
            servo.control_range,
            servo.max_force,
        )
    tendon = spec.add_tendon(name="drivers")
    for side in ("right", "left"):
        tendon.wrap_joint(f"{side}_driver", 0.5)
    _add_servo(
        spec,
        "drivers",
        mujoco.mjtTrn.mjTRN_TENDON,
        robot.GRIPPER_GAIN,
        robot.GRIPPER_STIFFNESS,
        robot.GRIPPER_DAMPING,
        (0, robot.GRIPPER_CONTROL_MAX),
        robot.GRIPPER_MAX_FORCE,
    )


def _add_servo(
    spec: mujoco.MjSpec,
    target: str,
    transmission: mujoco.mjtTrn,
    gain: float,
    stiffness: float,
    damping: float,
    control_range: robot.Vector,
    max_force: float,
) -> None:
    servo = spec.add_actuator(
        name=target,
        target=target,
        trntype=transmission,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        ctrllimited=True,
        ctrlrange=control_range,
        forcelimited=True,
        forcerange=(-max_force, max_force),
    )
    servo.gainprm[0] = gain
    servo.biasprm[1:3] = (-stiffness, -damping)


def _add_cube(spec: mujoco.MjSpec, index: int, num_cubes: int) -> str:
    name = f"cube_{index}"
    row, place = divmod(index, _ROW)
    x, y = 0.3 + 0.1 * row, 0.05 * (2 * place - (min(num_cubes, _ROW) - 1))
    body = spec.worldbody.add_body(name=name, pos=(x, y, CUBE_HALF_SIZE))
    body.add_freejoint(name=name)
    _add_box(body, name, (CUBE_HALF_SIZE,) * 3, density=CUBE_DENSITY)
    return name


def _add_contacts(spec: mujoco.MjSpec, cubes: list[str], pad_boxes: tuple[PadBox, ...]) -> None:
    pads = {f"{side}_pad_{i}": box for side in ("right", "left") for i, box in enumerate(pad_boxes)}
    links = [f"{box.link}_box" for box in LINK_BOXES]
    for cube in cubes:
        for other in ("floor", *WALLS, *links):
            _add_pair(spec, other, cube, CUBE_OTHER)
    for one, other in combinations(cubes, 2):
        _add_pair(spec, one, other, CUBE_CUBE)
    for name, box in pads.items():
        for touched in ("floor", *cubes):
            _add_pair(spec, touched, name, _pad_contact(box.friction))
    for (one, box), (other, other_box) in combinations(pads.items(), 2):
        if one.split("_")[0] != other.split("_")[0]:
            _add_pair(spec, one, other, _pad_contact(max(box.friction, other_box.friction)))


def _add_pair(spec: mujoco.MjSpec, one: str, other: str, contact: Contact) -> None:
    pair = spec.add_pair(geomname1=one, geomname2=other, condim=3)
    slide = contact.friction
    pair.friction[:] = (slide, slide, _TORSION, _ROLLING, _ROLLING)
    pair.solref[:2] = contact.solref
    pair.solimp[:3] = contact.solimp
