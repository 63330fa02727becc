"""Physics engines by name, to which a user's own file may add."""

import importlib.util

from pigbench import devices
from pigbench.envs.physics.base import Factors, Physics, PhysicsState, warn_of_overflow
from pigbench.envs.physics.mjx_jax import MjxJax
from pigbench.envs.physics.mjx_warp import MjxWarp
from pigbench.envs.physics.mujoco import MujocoPhysics
from pigbench.envs.scene import Scene
from pigbench.errors import lookup_own
from pigbench.names import require_new

ENGINES: dict[str, type[Physics]] = {
    engine.name: engine for engine in (MujocoPhysics, MjxWarp, MjxJax)
}


def register(engine: type[Physics]) -> None:
    """Register an engine under its `name`; `UserError` if the name is taken or invalid."""
    require_new("a physics engine", engine.name, ENGINES)
    ENGINES[engine.name] = engine


def default_engine() -> str:
    """The engine for the device that JAX runs on."""
    platform = devices.backend()
    if platform == "cpu":
        return MujocoPhysics.name
    has_warp = platform == "gpu" and importlib.util.find_spec("warp") is not None
    return MjxWarp.name if has_warp else MjxJax.name


def make(engine: str, scene: Scene) -> Physics:
    """The engine called `engine` on a scene; `UserError` if there is none."""
    return lookup_own("physics engine", ENGINES, engine)(scene)


__all__ = [
    "ENGINES",
    "Factors",
    "Physics",
    "PhysicsState",
    "default_engine",
    "make",
    "register",
    "warn_of_overflow",
]
