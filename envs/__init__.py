"""OGBench's cube environments in JAX: `make("cube-double")` gives a Brax `Env`."""

from pigbench.envs import physics as engines
from pigbench.envs.environment import CubeEnv, Spec, State
from pigbench.envs.physics import default_engine
from pigbench.envs.scene import build
from pigbench.envs.tasks import TASKS
from pigbench.errors import lookup

_SIZES = {
    "cube-single": (1, 200),
    "cube-double": (2, 500),
    "cube-triple": (3, 1000),
    "cube-quadruple": (4, 1000),
    "cube-octuple": (8, 1500),
}
SPECS = {
    name: Spec(name, num_cubes, episode_length, TASKS[name])
    for name, (num_cubes, episode_length) in _SIZES.items()
}


def names() -> tuple[str, ...]:
    """The registered environments."""
    return tuple(SPECS)


def make(name: str, engine: str | None = None, profile: str = "exact") -> CubeEnv:
    """The environment of that name; UserError for an unknown name.

    `engine` is one of `physics.ENGINES`, by default the one for JAX's device.
    """
    spec = lookup("environment", SPECS, name)
    scene = build(spec.num_cubes, profile)
    return CubeEnv(spec, engines.make(engine or default_engine(), scene))


__all__ = ["SPECS", "CubeEnv", "Spec", "State", "default_engine", "make", "names"]
