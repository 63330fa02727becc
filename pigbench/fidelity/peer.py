"""OGBench, used as its users do: its environments and its data generator."""

# mujoco's compiled modules carry no types.
# pyright: reportAttributeAccessIssue=false

import contextlib
import importlib
import warnings
from collections.abc import Iterator
from typing import Any, NamedTuple

import mujoco
import numpy as np
from jaxtyping import Float

from pigbench.envs.oracles.noisy import MAX_NOISE, NOISE_SCALE
from pigbench.errors import UserError, lookup

NAME = "ogbench"

Info = dict[str, Any]

# Policy -> module and class of OGBench's oracle, whose defaults are those of its data.
_ORACLES = {
    "play": ("ogbench.manipspace.oracles.plan.cube_plan", "CubePlanOracle"),
    "noisy": ("ogbench.manipspace.oracles.markov.cube_markov", "CubeMarkovOracle"),
}


class Step(NamedTuple):
    """One control step of OGBench's generator, with its environment's info before and after."""

    before: Info
    action: Float[np.ndarray, "action"]  # in [-1, 1]
    after: Info
    ended: bool  # whether the sub-task ended with this step


def make(environment: str, *, mode: str) -> Any:
    """OGBench's environment; `mode` is "task" or "data_collection". UserError if there is none."""
    with quiet():
        require("ogbench")  # registers its environments
        gymnasium = require("gymnasium")
        if f"{environment}-v0" not in gymnasium.registry:
            raise UserError(f"{NAME} has no environment {environment!r}")
        return gymnasium.make(f"{environment}-v0", mode=mode, terminate_at_goal=False).unwrapped


def quiet() -> contextlib.AbstractContextManager[object]:
    """A block in which OGBench warns neither of a missing display nor of its spaces' precision."""
    return warnings.catch_warnings(action="ignore")


def oracle(env: Any, policy: str) -> Any:
    """OGBench's scripted policy of that name."""
    module, name = lookup("policy", _ORACLES, policy)
    return getattr(require(module), name)(env=env)


def episode(env: Any, policy: str, *, seed: int, stacking: tuple[float, float]) -> Iterator[Step]:
    """Steps of an endless episode. Draws from NumPy's global random stream, as the oracles do.

    The probability of putting a cube on another is drawn from the range `stacking`.
    """
    draws = np.random.default_rng(seed)
    p_stack = draws.uniform(*stacking)
    noise = draws.uniform(0, MAX_NOISE) * np.array(NOISE_SCALE) * (policy == "noisy")
    agent = oracle(env, policy)
    observation, info = env.reset(seed=seed)
    agent.reset(observation, info)
    while True:
        before = info | {
            "observation": observation,
            "warmstart": env.data.qacc_warmstart.copy(),
        }
        intended = agent.select_action(observation, info)
        action = np.clip(intended + noise * draws.standard_normal(len(noise)), -1, 1)
        observation, _, _, _, info = env.step(action)
        yield Step(before, action, info, agent.done)
        if agent.done:
            observation, info = env.set_new_target(p_stack=p_stack)
            agent.reset(observation, info)


def place(
    env: Any, qpos: Float[np.ndarray, "nq"], targets: Float[np.ndarray, "cube 3"]
) -> Float[np.ndarray, "observation"]:
    """Set the scene at rest to `qpos`, and the cubes' targets, in metres.

    Returns the observation. The environment must have been reset once.
    """
    mujoco.mj_resetData(env.model, env.data)
    env.data.mocap_pos[env._cube_target_mocap_ids] = targets
    env.set_state(np.asarray(qpos, float), np.zeros(env.model.nv))
    mujoco.mj_rnePostConstraint(env.model, env.data)  # contact forces, as after a step
    env.pre_step()  # needed for an observation
    return env.compute_observation()


@contextlib.contextmanager
def numpy_seed(seed: int) -> Iterator[None]:
    """Seed NumPy's global stream, which OGBench's oracles use, and restore it afterwards."""
    before = np.random.get_state()
    np.random.seed(seed)
    try:
        yield
    finally:
        np.random.set_state(before)


def require(module: str) -> Any:
    """A module of OGBench or of its dependencies. Raises UserError if it is not installed."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise UserError("the ogbench package is not installed: pip install ogbench") from None
