"""Small data sets, run folders and an environment, made by hand, and a policy that succeeds."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest

from pigbench import cli, envs
from pigbench.agents import Statistics
from pigbench.data.manifest import Shard, Spec
from pigbench.data.writer import Writer
from pigbench.envs.oracles import markov
from pigbench.envs.oracles.targets import Target
from pigbench.envs.tasks import Task
from pigbench.envs.units import metres
from pigbench.evaluation import episodes
from pigbench.evaluation.episodes import Episode
from pigbench.evaluation.measures import Value
from pigbench.layout import Layout
from pigbench.runs import run as runs
from pigbench.runs.run import Run, RunConfig

# Four shards: train-00000 and -00001 of 2 episodes of 4 rows, train-00002 and val-00000 of 1.
SPEC = Spec(
    environment="cube-single",
    policy="play",
    physics="exact",
    engine="mujoco",
    seed=3,
    episodes={"train": 5, "val": 1},
    episodes_per_shard=2,
    rows_per_episode=4,
    fields=("observations", "actions", "terminals", "qpos"),
    layout=Layout.of({"joint_pos": 6, "cube_0_pos": 3}),
    action_size=5,
    versions={"mujoco": "1.0", "jax": "2.0", "pigbench": "3.0"},
)

CONFIG = RunConfig(
    method="gcivl",
    preset="cpu",
    agent={"discount": 0.99, "hidden": [256, 256], "goals": "state"},
    environment="cube-single",
    physics="exact",
    dataset_digest="ab" * 32,
    steps=200,
    seed=0,
    evaluation={"episodes": 2, "interval": 100, "engine": "mujoco"},
)


def arrays_of(spec: Spec, part: Shard, *, dropped: int = 0) -> dict[str, np.ndarray]:
    generator = np.random.default_rng((spec.seed, part.number))
    rows = (part.episodes - dropped) * spec.rows_per_episode
    widths = {"observations": 9, "actions": 5, "qpos": 7}
    arrays = {
        field: generator.normal(size=(rows, width)).astype(np.float32)
        for field, width in widths.items()
    }
    last = spec.rows_per_episode - 1
    return arrays | {"terminals": np.arange(rows) % spec.rows_per_episode == last}


def write_dataset(folder: Path, spec: Spec = SPEC) -> None:
    writer = Writer(folder, spec)
    for part in writer.missing():
        writer.write(part, arrays_of(spec, part))


def write_run(
    path: Path,
    outcomes: dict[int, list[list[int]]],
    *,
    more: Mapping[str, Value] = MappingProxyType({}),
    agent: Mapping[str, Any] = CONFIG.agent,
    **changes,
) -> Run:
    """A run with `outcomes[step][task - 1]`, the successes (0 or 1) of the task's episodes.

    `more` are further measures, the same of all episodes. Goals are states unless `agent` has them.
    """
    config = dataclasses.replace(CONFIG, agent={"goals": "state", **agent}, **changes)
    run = runs.open_run(path, config, {}, Statistics.standard(1))
    episodes.record(
        run.episodes_path,
        [
            Episode(step, task, f"task{task}", number, 7, "mujoco", measures)
            for step, tasks in outcomes.items()
            for task, successes in enumerate(tasks, start=1)
            for number, success in enumerate(successes)
            for measures in [{"success": bool(success), **more}]
        ],
    )
    return run


class Scripted:
    """OGBench's Markov oracle as a policy, its gripper action bounded by the parameter."""

    def __init__(self, layout):
        self.layout = layout

    def act(self, params, observation, goal, key):
        def position(values, term):
            return metres(values[self.layout[term]])

        def angle(values, term):
            cos, sin = values[self.layout[term]]
            return jnp.arctan2(sin, cos)

        situation = markov.OracleInputs(
            position(observation, "effector_pos"),
            angle(observation, "effector_yaw"),
            observation[self.layout["gripper_contact"]][0],
            position(observation, "cube_0_pos"),
            angle(observation, "cube_0_yaw"),
        )
        target = Target(
            jnp.zeros((), jnp.int32), position(goal, "cube_0_pos"), angle(goal, "cube_0_yaw")
        )
        action = markov.action(situation, target, markov.Pose(target.pos, target.yaw))
        return action.at[-1].set(jnp.minimum(action[-1], params))


@pytest.fixture
def spec() -> Spec:
    return SPEC


@pytest.fixture
def config() -> RunConfig:
    return CONFIG


@pytest.fixture
def imported(tmp_path) -> Path:
    """A data set that was imported, with the specification of logs'."""
    origin = {"arm.csv": "SHA-256 ab"}
    spec = dataclasses.replace(SPEC, policy="log", seed=0, versions={}, origin=origin)
    write_dataset(tmp_path / "imported", spec)
    return tmp_path / "imported"


@pytest.fixture
def arrays():
    return arrays_of


@pytest.fixture
def make_run():
    return write_run


@pytest.fixture(scope="session")
def env() -> "envs.CubeEnv":
    """A short environment of an easy and a hard task."""
    single = envs.make("cube-single")
    tasks = (
        Task("solved", ((0.4, 0.0),), ((0.4, 0.0),)),
        Task("far", ((0.4, 0.2),), ((0.4, -0.2),)),
    )
    spec = dataclasses.replace(single.spec, tasks=tasks, episode_length=6)
    return envs.CubeEnv(spec, single.physics)


@pytest.fixture(scope="session")
def scripted() -> type[Scripted]:
    return Scripted


@pytest.fixture(scope="session")
def played(tmp_path_factory) -> Path:
    """A data set of cube-single as generated: 2 episodes to train on and 1 more, of 101 rows."""
    folder = tmp_path_factory.mktemp("played") / "data"
    sizes = "--episodes 2 --validation-episodes 1 --episodes-per-shard 2 --episode-length 101"
    cli.run(["generate", "cube-single", "--out", str(folder), *sizes.split()])
    return folder


@pytest.fixture
def data(tmp_path) -> Path:
    """The folder of a complete data set."""
    write_dataset(tmp_path / "data")
    return tmp_path / "data"
