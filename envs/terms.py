"""The terms of the observation, available without importing JAX; `observation` has their values.

Robot terms come first, then the terms of each cube. Other code looks up slices by name, or by the
groups of `pigbench.layout`, which a term's name determines.
"""

from collections.abc import Collection
from dataclasses import dataclass

from pigbench.envs.units import CENTRE, OPENING_SCALE, PAD_FORCE_SCALE, POSITION_SCALE
from pigbench.errors import lookup
from pigbench.layout import Layout


@dataclass(frozen=True)
class Term:
    """A named part of the observation, its length `size`, and its meaning in words."""

    name: str
    size: int
    meaning: str


ROBOT_TERMS = (
    Term("joint_pos", 6, "angles of the arm's joints, rad"),
    Term("joint_vel", 6, "their velocities, rad/s"),
    Term("effector_pos", 3, f"pinch point minus {CENTRE} m, times {POSITION_SCALE:.0f}"),
    Term("effector_yaw", 2, "cosine and sine of the gripper's yaw"),
    Term("gripper_opening", 1, f"0 open to {OPENING_SCALE:.0f} shut"),
    Term(
        "gripper_contact", 1, f"force on the right pad over {1 / PAD_FORCE_SCALE:.0f}, clipped to 1"
    ),
)


def _cube_terms(index: int) -> tuple[Term, ...]:
    name = f"cube_{index}"
    centre = f"centre of cube {index} minus {CENTRE} m, times {POSITION_SCALE:.0f}"
    return (
        Term(f"{name}_pos", 3, centre),
        Term(f"{name}_quat", 4, "its quaternion, w first"),
        Term(f"{name}_yaw", 2, "cosine and sine of its yaw"),
    )


def table(num_cubes: int, unobserved: Collection[str] = ()) -> tuple[Term, ...]:
    """The observation's terms in order: all except those named in `unobserved`.

    Raises UserError if there is none of such a name.
    """
    cubes = (term for index in range(num_cubes) for term in _cube_terms(index))
    every = {term.name: term for term in (*ROBOT_TERMS, *cubes)}
    for name in unobserved:
        lookup("observation", every, name)
    return tuple(term for name, term in every.items() if name not in unobserved)


def layout(num_cubes: int, unobserved: Collection[str] = ()) -> Layout:
    """The layout of these terms. Raises UserError if there is none of a name in `unobserved`."""
    return Layout.of({term.name: term.size for term in table(num_cubes, unobserved)})
