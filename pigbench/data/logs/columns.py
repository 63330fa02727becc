"""The columns of a robot's log, one table per episode: their units and plausible ranges.

Positions are in the frame of the UR5e's controller, "base": origin at the robot's foot, z up.
Joints have the controller's order (base, shoulder, elbow, wrist 1 to 3) and zeros. Yaw is about z,
from the frame's x axis to the gripper's, across which its fingers close. An object's pose is that
of its centre, a commanded pose that of the point between the fingertips.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from pigbench.envs.units import ACTION_SIZE
from pigbench.errors import UserError

LogTable = Mapping[str, Float[np.ndarray, "row"]]
"""An episode's columns by name."""
LogGroups = Mapping[str, Float[np.ndarray, "row _"]]
"""An episode's groups of columns by name."""


@dataclass(frozen=True)
class Group:
    """Columns that occur together.

    Attributes:
        names: their names.
        unit: their unit.
        low, high: bounds of plausible numbers.
        mistaken: what numbers out of bounds are likely to be.
    """

    names: tuple[str, ...]
    unit: str
    low: float
    high: float
    mistaken: str


def _numbered(name: str, count: int) -> tuple[str, ...]:
    return tuple(f"{name}_{number}" for number in range(count))


_FULL_TURN = 2 * np.pi + 0.01

TIME = Group(("time",), "s", -np.inf, np.inf, "")
REQUIRED = {
    "joint_pos": Group(_numbered("joint_pos", 6), "rad", -_FULL_TURN, _FULL_TURN, "degrees"),
    "gripper_opening": Group(
        ("gripper_opening",), "0 open to 1 shut", -0.02, 1.02, "percent, millimetres or counts"
    ),
    "object_pos": Group(("object_x", "object_y", "object_z"), "m", -2.0, 2.0, "millimetres"),
    "object_quat": Group(
        ("object_qw", "object_qx", "object_qy", "object_qz"), "1", -1.02, 1.02, "not normalised"
    ),
}
OPTIONAL = {
    "joint_vel": Group(_numbered("joint_vel", 6), "rad/s", -7.0, 7.0, "degrees per second"),
    "gripper_contact": Group(("gripper_contact",), "0 to 1", -0.02, 1.02, "newtons or counts"),
    "target_pos": Group(("target_x", "target_y", "target_z"), "m", -2.0, 2.0, "millimetres"),
    "target_yaw": Group(("target_yaw",), "rad", -_FULL_TURN, _FULL_TURN, "degrees"),
    "target_opening": Group(
        ("target_opening",), "0 open to 1 shut", -0.02, 1.02, "percent, millimetres or counts"
    ),
    "action": Group(
        _numbered("action", ACTION_SIZE), "of the largest move", -20.0, 20.0, "absolute poses"
    ),
}
"""Without velocities, they are derived from positions; without contact, it is inferred from fingers
that rest between open and shut. Either actions or commanded poses (all three groups) are needed."""

TARGETS = ("target_pos", "target_yaw", "target_opening")


def groups(name: str, table: LogTable) -> LogGroups:
    """The groups in a table. `name` names the table in error messages.

    Raises UserError if columns are missing or numbers are implausible.
    """
    known = {"time": TIME, **REQUIRED, **OPTIONAL}
    found = {}
    for key, group in known.items():
        missing = [column for column in group.names if column not in table]
        if missing and (key in REQUIRED or key == "time" or len(missing) < len(group.names)):
            raise UserError(f"{name} has no column {missing[0]} ({key}, {group.unit})")
        if not missing:
            found[key] = np.stack([table[column] for column in group.names], axis=-1)
    if "action" not in found and not found.keys() >= set(TARGETS):
        raise UserError(
            f"{name} has neither action_0 to action_4 nor commanded poses (target_x ...)"
        )
    for key, values in found.items():
        _check_range(name, known[key], values)
    return found


def _check_range(name: str, group: Group, values: Float[np.ndarray, "row _"]) -> None:
    for column, numbers in zip(group.names, values.T, strict=True):
        if not np.isfinite(numbers).all():
            row = int(np.argmin(np.isfinite(numbers)))
            raise UserError(f"{name}: {column} is not a number in row {row}")
        beyond = (numbers < group.low) | (numbers > group.high)
        if beyond.any():
            row = int(beyond.argmax())
            raise UserError(
                f"{name}: {column} is {numbers[row]:g} in row {row}: its unit is {group.unit}; "
                f"is it {group.mistaken}?"
            )
