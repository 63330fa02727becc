"""The `ogbench` package as the reference: its environments, and stretches of its own play."""

import contextlib
from collections.abc import Callable, Iterator
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


class Recording(NamedTuple):
    """What OGBench's oracle does in OGBench's simulator: one row a control step."""

    qpos: np.ndarray  # before the step, as all but the last two
    qvel: np.ndarray
    contact: np.ndarray  # of the gripper, in [0, 1]
    stacked: np.ndarray  # whether a cube rests on another
    ctrl: np.ndarray
    ended: np.ndarray  # whether the step is a sub-task's last
    success: np.ndarray  # whether the cube is then at its target


@pytest.fixture(scope="session")
def numpy_seed() -> Callable[[int], contextlib.AbstractContextManager]:
    """`with numpy_seed(n)`: NumPy's global stream, which OGBench's oracles use, begins at n."""

    @contextlib.contextmanager
    def seeded(seed: int) -> Iterator[None]:
        before = np.random.get_state()
        np.random.seed(seed)
        yield
        np.random.set_state(before)

    return seeded


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
def play(ogbench_env, numpy_seed) -> Callable[..., Recording]:
    """`play(name, steps, seed, stacking)`: a recording of an episode of OGBench's play."""

    @cache
    def record(name: str, steps: int, seed: int = 0, stacking: float = 0.5) -> Recording:
        env = ogbench_env(name)
        oracle = CubePlanOracle(env=env)
        rows = []
        with numpy_seed(seed):
            observation, info = env.reset(seed=seed)
            oracle.reset(observation, info)
            for _ in range(steps):
                qpos = info["qpos"]
                stacked = _any_stacked(qpos[14:].reshape(-1, 7)[:, :3])
                before = (qpos, info["qvel"], info["proprio/gripper_contact"][0], stacked)
                observation, _, _, _, info = env.step(oracle.select_action(observation, info))
                rows.append((*before, info["control"], oracle.done, info["success"]))
                if oracle.done:
                    observation, info = env.set_new_target(p_stack=stacking)
                    oracle.reset(observation, info)
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
