"""The observation: each of its `terms` is a small function of the simulation's state."""

from collections.abc import Callable, Iterable, Mapping

import jax.numpy as jnp
from jaxtyping import Array, Float

from pigbench.envs import robot
from pigbench.envs.physics import PhysicsState
from pigbench.envs.rotations import quat_yaw
from pigbench.envs.scene import Scene
from pigbench.envs.units import CENTRE, OPENING_SCALE, PAD_FORCE_SCALE, POSITION_SCALE


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


_ROBOT: Mapping[str, Callable[[Scene, PhysicsState], Float[Array, "size"]]] = {
    "joint_pos": lambda scene, state: state.qpos[scene.arm],
    "joint_vel": lambda scene, state: state.qvel[scene.arm],
    "effector_pos": lambda scene, state: _scaled(state.pinch_pos),
    "effector_yaw": lambda scene, state: _direction(state.pinch_yaw),
    "gripper_opening": lambda scene, state: gripper_opening(scene, state)[None] * OPENING_SCALE,
    "gripper_contact": lambda scene, state: gripper_contact(state)[None],
}
_CUBE: Mapping[str, Callable[[Float[Array, "3"], Float[Array, "4"]], Float[Array, "size"]]] = {
    "pos": lambda pos, quat: _scaled(pos),
    "quat": lambda pos, quat: quat,
    "yaw": lambda pos, quat: _direction(quat_yaw(quat)),
}


def observe(names: Iterable[str], scene: Scene, state: PhysicsState) -> Float[Array, "observation"]:
    """The observation of one simulation: the values of the terms with these names, in order."""
    positions, quats = cube_poses(scene, state)
    values = {name: value(scene, state) for name, value in _ROBOT.items()} | {
        f"cube_{index}_{name}": value(positions[index], quats[index])
        for index in range(scene.num_cubes)
        for name, value in _CUBE.items()
    }
    return jnp.concatenate([values[name] for name in names])
