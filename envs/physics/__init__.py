"""Physics engines by name."""

from collections.abc import Callable

from pigbench.envs.physics.base import Physics, PhysicsState
from pigbench.envs.physics.mujoco import MujocoPhysics
from pigbench.envs.scene import Scene
from pigbench.errors import lookup

ENGINES: dict[str, Callable[[Scene], Physics]] = {
    engine.name: engine for engine in (MujocoPhysics,)
}
DEFAULT_ENGINE = MujocoPhysics.name


def make(engine: str, scene: Scene) -> Physics:
    """The engine of that name on a scene; UserError if there is none."""
    return lookup("physics engine", ENGINES, engine)(scene)


__all__ = ["DEFAULT_ENGINE", "ENGINES", "Physics", "PhysicsState", "make"]
