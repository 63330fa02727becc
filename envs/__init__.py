"""OGBench's cube environments and a real robot's, in JAX: `make("cube-double")` is a Brax `Env`.

Brax and MuJoCo take long to import, so they are imported only when an environment is made, not to
list environments.
"""

from typing import TYPE_CHECKING, Any

from pigbench import devices
from pigbench.envs.reality import REAL, Reality
from pigbench.envs.spec import EnvSpec
from pigbench.envs.tasks import TASKS, Task
from pigbench.errors import lookup_own
from pigbench.names import require_new

if TYPE_CHECKING:
    from pigbench.envs.environment import CubeEnv, State

_ALL = (
    EnvSpec("cube-single", 1, 200, TASKS["cube-single"], stacking=(0.0, 0.0)),
    EnvSpec("cube-double", 2, 500, TASKS["cube-double"], stacking=(0.0, 0.25)),
    EnvSpec("cube-triple", 3, 1000, TASKS["cube-triple"], stacking=(0.05, 0.35)),
    EnvSpec("cube-quadruple", 4, 1000, TASKS["cube-quadruple"], stacking=(0.1, 0.5)),
    EnvSpec("cube-octuple", 8, 1500, TASKS["cube-octuple"], stacking=(0.0, 0.35)),
    EnvSpec(
        "cube-centre",
        1,
        200,
        TASKS["cube-centre"],
        success_distance=0.03,  # the smallest of the paper's three, since success ends an episode
        unobserved=frozenset({"effector_pos"}),  # not among the observations that the paper lists
        reality=REAL,
        policy="replan",
    ),
)
SPECS = {spec.name: spec for spec in _ALL}


def register(spec: EnvSpec) -> None:
    """Register an environment under its name; `UserError` if the name is taken or invalid."""
    require_new("an environment", spec.name, SPECS)
    SPECS[spec.name] = spec


def names() -> tuple[str, ...]:
    """The names of the registered environments."""
    return tuple(SPECS)


def get(name: str) -> EnvSpec:
    """The environment called `name`; `UserError` if there is none."""
    return lookup_own("environment", SPECS, name)


def default_engine() -> str:
    """The engine for the device that JAX runs on."""
    from pigbench.envs import physics

    return physics.default_engine()


def make(
    name: str,
    engine: str | None = None,
    profile: str = "exact",
    reality: Reality | None = None,
    reward: str = "sparse",
) -> "CubeEnv":
    """The environment called `name`; `UserError` if it or another name is unknown.

    `engine` is a key of `physics.ENGINES`, by default the one for JAX's device. `reality` holds the
    imperfections of sensing and acting, by default the environment's own; `Reality()` has none.
    `reward` is a key of `rewards.REWARDS`, by default the benchmark's.
    """
    from pigbench.envs import environment, physics
    from pigbench.envs.scene import build

    spec = get(name)
    devices.backend()  # raises before the environment's first computation would
    scene = build(spec.num_cubes, profile)
    simulated = physics.make(engine or default_engine(), scene)
    return environment.CubeEnv(spec, simulated, reality or spec.reality, reward)


def __getattr__(name: str) -> Any:
    if name in ("CubeEnv", "State"):
        from pigbench.envs import environment

        return getattr(environment, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__all__ = [
    "SPECS",
    "CubeEnv",
    "EnvSpec",
    "State",
    "Task",
    "default_engine",
    "get",
    "make",
    "names",
    "register",
]
