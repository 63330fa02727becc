"""The observation: a table of named terms, each a small function of the simulation's state.

Robot terms come first, then the terms of each cube. Other code looks up slices by name, or by the
groups of `pigbench.layout`, which a term's name determines.
"""

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass

import jax.numpy as jnp
from jaxtyping import Array, Float

from pigbench.envs import robot
from pigbench.envs.physics import PhysicsState
from pigbench.envs.rotations import quat_yaw
from pigbench.envs.scene import Scene
from pigbench.envs.units import CENTRE, POSITION_SCALE
from pigbench.errors import lookup
from pigbench.layout import Layout

# Scales that bring every term to order 1, as in OGBench.
OPENING_SCALE = 3.0
PAD_FORCE_SCALE = 1 / 50


@dataclass(frozen=True)
class Term:
    """A named part of the observation, its length `size`, and its meaning in words."""

    name: str
    size: int
    meaning: str
    value: Callable[[Scene, PhysicsState], Float[Array, "size"]]


def gripper_opening(scene: Scene, state: PhysicsState) -> Float[Array, ""]:
    """The gripper's opening in OGBench's sense, in [0, 1]: 0 is open and 1 is shut."""
    return jnp.clip(state.qpos[scene.driver] / robot.GRIPPER_CLOSED, 0.0, 1.0)


def gripper_contact(state: PhysicsState) -> Float[Array, "*batch"]:
    """The force on the right finger's pad, scaled and clipped to [0, 1]."""
    return jnp.clip(state.pad_force * PAD_FORCE_SCALE, 0.0, 1.0)


def cube_poses(
    scene: Scene, state: PhysicsState
) -> tuple[Float[Array, "cube 3"], Float[Array, "cube 4"]]:
    """Cube positions in metres, and quaternions."""
    poses = state.qpos[scene.cubes_qpos].reshape(scene.num_cubes, 7)
    return poses[:, :3], poses[:, 3:]


def _scaled(position: Float[Array, "3"]) -> Float[Array, "3"]:
    return (position - jnp.array(CENTRE)) * POSITION_SCALE


def _direction(angle: Float[Array, ""]) -> Float[Array, "2"]:
    return jnp.stack([jnp.cos(angle), jnp.sin(angle)])


ROBOT_TERMS = (
    Term(
        "joint_pos",
        6,
        "angles of the arm's joints, rad",
        lambda scene, state: state.qpos[scene.arm],
    ),
    Term("joint_vel", 6, "their velocities, rad/s", lambda scene, state: state.qvel[scene.arm]),
    Term(
        "effector_pos",
        3,
        f"pinch point minus {CENTRE} m, times {POSITION_SCALE:.0f}",
        lambda scene, state: _scaled(state.pinch_pos),
    ),
    Term(
        "effector_yaw",
        2,
        "cosine and sine of the gripper's yaw",
        lambda scene, state: _direction(state.pinch_yaw),
    ),
    Term(
        "gripper_opening",
        1,
        f"0 open to {OPENING_SCALE:.0f} shut",
        lambda scene, state: gripper_opening(scene, state)[None] * OPENING_SCALE,
    ),
    Term(
        "gripper_contact",
        1,
        f"force on the right pad over {1 / PAD_FORCE_SCALE:.0f}, clipped to 1",
        lambda scene, state: gripper_contact(state)[None],
    ),
)


def _cube_terms(index: int) -> tuple[Term, ...]:
    def pos(scene: Scene, state: PhysicsState) -> Float[Array, "3"]:
        return cube_poses(scene, state)[0][index]

    def quat(scene: Scene, state: PhysicsState) -> Float[Array, "4"]:
        return cube_poses(scene, state)[1][index]

    return (
        Term(
            f"cube_{index}_pos",
            3,
            f"centre of cube {index} minus {CENTRE} m, times {POSITION_SCALE:.0f}",
            lambda scene, state: _scaled(pos(scene, state)),
        ),
        Term(f"cube_{index}_quat", 4, "its quaternion, w first", quat),
        Term(
            f"cube_{index}_yaw",
            2,
            "cosine and sine of its yaw",
            lambda scene, state: _direction(quat_yaw(quat(scene, state))),
        ),
    )


def table(num_cubes: int, unobserved: Collection[str] = ()) -> tuple[Term, ...]:
    """The observation's terms in order: all except those named in `unobserved`.

    Raises UserError if there is none of such a name.
    """
    cubes = (_cube_terms(index) for index in range(num_cubes))
    every = (*ROBOT_TERMS, *(term for cube in cubes for term in cube))
    for name in unobserved:
        lookup("observation", {term.name: term for term in every}, name)
    return tuple(term for term in every if term.name not in unobserved)


def layout(num_cubes: int, unobserved: Collection[str] = ()) -> Layout:
    """The layout of these terms."""
    return Layout.of({term.name: term.size for term in table(num_cubes, unobserved)})


def observe(
    terms: Iterable[Term], scene: Scene, state: PhysicsState
) -> Float[Array, "observation"]:
    """The observation of one simulation."""
    return jnp.concatenate([term.value(scene, state) for term in terms])
