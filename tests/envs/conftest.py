"""The `ogbench` package as the reference: its environments, and stretches of its own play."""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import gymnasium
import mujoco
import numpy as np
import ogbench  # noqa: F401  registers the environments
import pytest
from ogbench.manipspace.oracles.plan.cube_plan import CubePlanOracle

from pigbench import envs
from pigbench.envs import CubeEnv
from pigbench.envs.scene import Scene, build

PLAY_STACKING = 0.5


class Recording(NamedTuple):
    """What OGBench's oracle does in OGBench's simulator: one row a control step."""

    qpos: np.ndarray
    qvel: np.ndarray
    warmstart: np.ndarray
    ctrl: np.ndarray
    contact: np.ndarray  # of the gripper, in [0, 1]
    stacked: np.ndarray  # whether a cube rests on another


@pytest.fixture(scope="session")
def ogbench_env() -> Callable[..., Any]:
    """`ogbench_env(name)`: OGBench's environment, reset; `mode` is "task" or "data_collection"."""

    @cache
    def make(name: str, mode: str = "data_collection") -> Any:
        env = gymnasium.make(f"{name}-v0", mode=mode, terminate_at_goal=False).unwrapped
        env.reset(seed=0)
        return env

    return make


@pytest.fixture(scope="session")
def place(ogbench_env) -> Callable[..., Any]:
    """`place(name, qpos, qvel)`: OGBench's environment there, controls zero, forces computed."""

    def place(name: str, qpos: np.ndarray, qvel: np.ndarray | None = None) -> Any:
        env = ogbench_env(name)
        env.data.ctrl[:] = 0
        env.set_state(np.asarray(qpos, float), np.zeros(env.model.nv) if qvel is None else qvel)
        mujoco.mj_rnePostConstraint(env.model, env.data)
        return env

    return place


@pytest.fixture(scope="session")
def play(ogbench_env) -> Callable[[str, int], Recording]:
    """`play(name, steps)`: a recording of OGBench's play."""

    @cache
    def record(name: str, steps: int) -> Recording:
        env = ogbench_env(name)
        global_state = np.random.get_state()
        np.random.seed(0)  # the oracle draws from NumPy's global stream
        observation, info = env.reset(seed=0)
        oracle = CubePlanOracle(env=env)
        oracle.reset(observation, info)
        rows = []
        for _ in range(steps):
            data = env.data
            before = (data.qpos.copy(), data.qvel.copy(), data.qacc_warmstart.copy())
            contact = info["proprio/gripper_contact"][0]
            stacked = _any_stacked(before[0][14:].reshape(-1, 7)[:, :3])
            observation, _, _, _, info = env.step(oracle.select_action(observation, info))
            rows.append((*before, data.ctrl.copy(), contact, stacked))
            if oracle.done:
                oracle.reset(*env.set_new_target(p_stack=PLAY_STACKING))
        np.random.set_state(global_state)
        return Recording(*(np.array(column) for column in zip(*rows, strict=True)))

    return record


def _any_stacked(cubes: np.ndarray) -> bool:
    """Whether some cube's centre is right above another's, one edge of 4 cm higher."""
    offset = cubes[:, None] - cubes
    above = np.abs(offset[..., 2] - 0.04) < 0.002
    return bool(np.any(above & (np.linalg.norm(offset[..., :2], axis=-1) < 0.02)))


@pytest.fixture(scope="session")
def scene() -> Callable[..., Scene]:
    """`scene(num_cubes, profile)`: ours, compiled once."""
    return cache(build)


@pytest.fixture(scope="session")
def env() -> Callable[[str], CubeEnv]:
    """`env(name)`: ours, made once."""
    return cache(envs.make)
