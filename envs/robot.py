"""The UR5e arm with the Robotiq 2F-85 gripper, as tables of links, joints and actuators.

Lengths are in metres, masses in kilograms, angles in radians. The numbers are those of the robot in
OGBench (which takes them from the manufacturers' descriptions); inertias that OGBench derives from
meshes are given here by their compiled values.
"""

import math
from dataclasses import dataclass
from typing import Any

Vector = tuple[float, ...]

# Softness (time constant, damping ratio) and impedance of the gripper's linkage and joint limits.
STIFF_SOLREF: Vector = (0.005, 1.0)
STIFF_SOLIMP: Vector = (0.95, 0.99, 0.001)
DEFAULT_SOLREF: Vector = (0.02, 1.0)
DEFAULT_SOLIMP: Vector = (0.9, 0.95, 0.001)


@dataclass(frozen=True)
class Joint:
    """A link's hinge: axis and anchor in the link's frame, limits, and passive dynamics."""

    name: str
    axis: Vector
    limits: Vector
    armature: float
    anchor: Vector = (0.0, 0.0, 0.0)
    damping: float = 0.0
    stiffness: float = 0.0
    spring_reference: float = 0.0
    limit_solref: Vector = DEFAULT_SOLREF
    limit_solimp: Vector = DEFAULT_SOLIMP


@dataclass(frozen=True)
class Link:
    """A rigid body: pose in its parent's frame, inertia in its own frame, and its joint, if any."""

    name: str
    parent: str
    pos: Vector
    mass: float
    inertia: Vector
    quat: Vector = (1.0, 0.0, 0.0, 0.0)
    com: Vector = (0.0, 0.0, 0.0)
    inertia_quat: Vector = (1.0, 0.0, 0.0, 0.0)
    joint: Joint | None = None


@dataclass(frozen=True)
class Servo:
    """A position servo: force = gain * control - stiffness * position - damping * velocity."""

    joint: str
    gain: float
    damping: float
    control_range: Vector
    max_force: float


_Y: Vector = (0.0, 1.0, 0.0)
_Z: Vector = (0.0, 0.0, 1.0)
_TURN: Vector = (-6.28319, 6.28319)
_HALF: Vector = (-3.1415, 3.1415)
_QUARTER_Y: Vector = (1.0, 0.0, 1.0, 0.0)


def _arm_joint(name: str, axis: Vector, limits: Vector = _TURN) -> Joint:
    return Joint(name, axis, limits, armature=0.1)


# Distances between the arm's joint axes, from which links and inverse kinematics follow.
SHOULDER_HEIGHT = 0.163
SHOULDER_OFFSET = 0.138
ELBOW_OFFSET = -0.131
UPPER_ARM = 0.425
FOREARM = 0.392
WRIST_1_OFFSET = 0.127
WRIST_2_OFFSET = 0.1
FLANGE_OFFSET = 0.1
GRIPPER_MOUNT = 0.007
GRIPPER_BASE = 0.0038
PINCH_HEIGHT = 0.145

ARM = (
    Link(
        "base", "world", (0, 0, 0), 4.0, (0.00443333156, 0.00443333156, 0.0072), quat=(1, 0, 0, 1)
    ),
    Link(
        "shoulder",
        "base",
        (0, 0, SHOULDER_HEIGHT),
        3.7,
        (0.0102675, 0.0102675, 0.00666),
        joint=_arm_joint("shoulder_pan", _Z),
    ),
    Link(
        "upper_arm",
        "shoulder",
        (0, SHOULDER_OFFSET, 0),
        8.393,
        (0.133886, 0.133886, 0.0151074),
        quat=_QUARTER_Y,
        com=(0, 0, 0.2125),
        joint=_arm_joint("shoulder_lift", _Y),
    ),
    Link(
        "forearm",
        "upper_arm",
        (0, ELBOW_OFFSET, UPPER_ARM),
        2.275,
        (0.0311796, 0.0311796, 0.004095),
        com=(0, 0, 0.196),
        joint=_arm_joint("elbow", _Y, _HALF),
    ),
    Link(
        "wrist_1",
        "forearm",
        (0, 0, FOREARM),
        1.219,
        (0.0025599, 0.0025599, 0.0021942),
        quat=_QUARTER_Y,
        com=(0, WRIST_1_OFFSET, 0),
        joint=_arm_joint("wrist_1", _Y),
    ),
    Link(
        "wrist_2",
        "wrist_1",
        (0, WRIST_1_OFFSET, 0),
        1.219,
        (0.0025599, 0.0025599, 0.0021942),
        com=(0, 0, 0.1),
        joint=_arm_joint("wrist_2", _Z),
    ),
    Link(
        "wrist_3",
        "wrist_2",
        (0, 0, WRIST_2_OFFSET),
        0.1889,
        (0.000132134, 9.90863e-05, 9.90863e-05),
        com=(0, 0.0771683, 0),
        inertia_quat=(1, 0, 0, 1),
        joint=_arm_joint("wrist_3", _Y),
    ),
    Link(
        "gripper_mount",
        "wrist_3",
        (0, FLANGE_OFFSET + GRIPPER_MOUNT, 0),
        0.15000285516,
        (1.02345489e-04, 5.35996872e-05, 5.21717631e-05),
        quat=(-1, 1, 0, 0),
        com=(-3.60583596e-04, 8.53627480e-05, -5.91991415e-05),
        inertia_quat=(-5.12917439e-04, 7.06099762e-01, 5.32990364e-04, 7.08111981e-01),
    ),
    Link(
        "gripper_base",
        "gripper_mount",
        (0, 0, GRIPPER_BASE),
        0.777441,
        (0.000260285, 0.000225381, 0.000152708),
        quat=(1, 0, 0, -1),
        com=(0, -2.70394e-05, 0.0354675),
        inertia_quat=(1, -0.00152849, 0, 0),
    ),
)

# The driver angle at which the fingers are shut: an opening of 1 in OGBench's sense.
GRIPPER_CLOSED = 0.8


def _finger(side: str) -> tuple[Link, ...]:
    """One finger's four-bar linkage; the left one is the right one rotated half a turn about z."""
    sign = {"right": 1.0, "left": -1.0}[side]
    quat = {"right": (1.0, 0.0, 0.0, 0.0), "left": (0.0, 0.0, 0.0, 1.0)}[side]

    def hinge(name: str, limits: Vector, stiff_limits: bool = True, **dynamics: Any) -> Joint:
        softness = (
            (STIFF_SOLREF, STIFF_SOLIMP) if stiff_limits else (DEFAULT_SOLREF, DEFAULT_SOLIMP)
        )
        return Joint(
            f"{side}_{name}",
            (1.0, 0.0, 0.0),
            limits,
            limit_solref=softness[0],
            limit_solimp=softness[1],
            **dynamics,
        )

    return (
        Link(
            f"{side}_driver",
            "gripper_base",
            (0, sign * 0.0306011, 0.054904),
            0.00899563,
            (1.72352e-06, 1.60906e-06, 3.22006e-07),
            quat=quat,
            com=(2.96931e-12 if side == "right" else 0.0, 0.0177547, 0.00107314),
            inertia_quat=(0.681301, 0.732003, 0, 0),
            joint=hinge("driver", (0.0, GRIPPER_CLOSED), armature=0.005, damping=0.1),
        ),
        Link(
            f"{side}_coupler",
            f"{side}_driver",
            (0, 0.0315, -0.0041),
            0.0140974,
            (4.16206e-06, 3.52216e-06, 8.88131e-07),
            com=(0, 0.00301209, 0.0232175),
            inertia_quat=(0.705636, -0.0455904, 0.0455904, 0.705636),
            joint=hinge("coupler", (-1.57, 0.0), armature=0.001),
        ),
        Link(
            f"{side}_spring_link",
            "gripper_base",
            (0, sign * 0.0132, 0.0609),
            0.0221642,
            (8.96853e-06, 6.71733e-06, 2.63931e-06),
            quat=quat,
            com=(-8.65005e-09, 0.0181624, 0.0212658),
            inertia_quat=(0.663403, -0.244737, 0.244737, 0.663403),
            joint=hinge(
                "spring_link",
                (-0.29670597283, GRIPPER_CLOSED),
                stiff_limits=False,
                armature=0.001,
                damping=0.00125,
                stiffness=0.05,
                spring_reference=2.62,
            ),
        ),
        Link(
            f"{side}_follower",
            f"{side}_spring_link",
            (0, 0.055, 0.0375),
            0.0125222,
            (2.67415e-06, 2.4559e-06, 6.02031e-07),
            com=(0, -0.011046, 0.0124786),
            inertia_quat=(1, 0.1664, 0, 0),
            joint=hinge(
                "follower", (-0.872664, 0.872664), armature=0.001, anchor=(0, -0.018, 0.0065)
            ),
        ),
        Link(
            f"{side}_pad",
            f"{side}_follower",
            (0, -0.0189, 0.01352),
            0.0035,
            (4.73958e-07, 3.64583e-07, 1.23958e-07),
            com=(0, -0.0025, 0.0185),
            inertia_quat=(1, 0, 0, 1),
        ),
        Link(
            f"{side}_silicone",
            f"{side}_pad",
            (0, 0, 0),
            0.001302811839,
            (2.00804321e-07, 1.49536006e-07, 5.18241812e-08),
            com=(0, -0.0058, 0.018517375),
            inertia_quat=(1, 0, 0, 1),
        ),
    )


LINKS = (*ARM, *_finger("right"), *_finger("left"))

ARM_SERVOS = (
    Servo("shoulder_pan", 4500, 400, (-6.2831, 6.2831), 150),
    Servo("shoulder_lift", 4500, 400, (-6.2831, 6.2831), 150),
    Servo("elbow", 4500, 400, (-3.1415, 3.1415), 150),
    Servo("wrist_1", 2000, 100, (-6.2831, 6.2831), 28),
    Servo("wrist_2", 2000, 100, (-6.2831, 6.2831), 28),
    Servo("wrist_3", 500, 100, (-6.2831, 6.2831), 28),
)

# The gripper's servo acts on the mean driver angle; its control is 0 (open) to 255 (shut).
GRIPPER_CONTROL_MAX = 255.0
GRIPPER_GAIN = 0.3137255
GRIPPER_STIFFNESS = 100.0
GRIPPER_DAMPING = 10.0
GRIPPER_MAX_FORCE = 5.0

ARM_JOINTS = tuple(servo.joint for servo in ARM_SERVOS)
GRIPPER_JOINTS = tuple(
    link.joint.name for link in LINKS if link.joint and link.joint.name not in ARM_JOINTS
)
HOME = (-math.pi / 2, -math.pi / 2, math.pi / 2, -math.pi / 2, -math.pi / 2, 0.0)
