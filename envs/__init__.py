"""OGBench's cube environments in JAX: `make("cube-double")` gives a Brax `Env`."""

from pigbench.envs import physics as engines
from pigbench.envs.environment import CubeEnv, Spec, State
from pigbench.envs.scene import build
from pigbench.envs.tasks import TASKS
from pigbench.errors import lookup

DEFAULT_ENGINE = engines.DEFAULT_ENGINE
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


def make(name: str, engine: str = DEFAULT_ENGINE, profile: str = "exact") -> CubeEnv:
    """The environment of that name on a physics engine; UserError for an unknown name."""
    spec = lookup("environment", SPECS, name)
    return CubeEnv(spec, engines.make(engine, build(spec.num_cubes, profile)))


__all__ = ["DEFAULT_ENGINE", "SPECS", "CubeEnv", "Spec", "State", "make", "names"]
