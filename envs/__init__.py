"""OGBench's cube environments and a real robot's, in JAX: `make("cube-double")` is a Brax `Env`.

Brax, and the MJX that comes with it, take seconds to import, so they are imported only when an
environment is made, not to list environments.
"""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from pigbench.envs.scene import build
from pigbench.envs.tasks import TASKS, Spec, Task
from pigbench.errors import UserError, lookup
from pigbench.names import check

if TYPE_CHECKING:
    from pigbench.envs.environment import CubeEnv, State
    from pigbench.envs.reality import Reality

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
SPECS["cube-centre"] = replace(
    SPECS["cube-single"],
    name="cube-centre",
    tasks=TASKS["cube-centre"],
    success_distance=0.03,  # the smallest of the paper's three, since success ends an episode
    unobserved=frozenset({"effector_pos"}),  # not among the observations that the paper lists
    real=True,
    policy="replan",
)


def register(spec: Spec) -> None:
    """Register an environment under its name; `UserError` if the name is taken or invalid."""
    check("an environment", spec.name)
    if spec.name in SPECS:
        raise UserError(f"environment {spec.name!r} is already registered: choose another name")
    SPECS[spec.name] = spec


def names() -> tuple[str, ...]:
    """The names of the registered environments."""
    return tuple(SPECS)


def default_engine() -> str:
    """The engine for the device that JAX runs on."""
    from pigbench.envs import physics

    return physics.default_engine()


def make(
    name: str,
    engine: str | None = None,
    profile: str = "exact",
    reality: "Reality | None" = None,
    reward: str = "sparse",
) -> "CubeEnv":
    """The environment called `name`; `UserError` if there is none.

    `engine` is a key of `physics.ENGINES`, by default the one for JAX's device. `reality` holds the
    imperfections of sensing and acting; the default is `REAL` for a real robot's environment, else
    none. `reward` is a key of `rewards.REWARDS`, by default the benchmark's.
    """
    from pigbench.envs import environment, physics
    from pigbench.envs.reality import REAL

    spec = lookup("environment", SPECS, name)
    scene = build(spec.num_cubes, profile)
    reality = REAL if reality is None and spec.real else reality
    simulated = physics.make(engine or default_engine(), scene)
    return environment.CubeEnv(spec, simulated, reality, reward)


def __getattr__(name: str) -> Any:
    if name in ("CubeEnv", "State"):
        from pigbench.envs import environment

        return getattr(environment, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__all__ = [
    "SPECS",
    "CubeEnv",
    "Spec",
    "State",
    "Task",
    "default_engine",
    "make",
    "names",
    "register",
]
