"""A small data set and a run on it, as commands would have left them; nothing is simulated."""

import math
import os
import shlex
from pathlib import Path

import jax
import numpy as np
import pytest

from pigbench import agents, cli, envs
from pigbench.agents import Statistics
from pigbench.data import collect, dataset
from pigbench.data.manifest import Spec
from pigbench.data.sampler import Rows
from pigbench.data.writer import Writer
from pigbench.training import episodes
from pigbench.training.checkpoints import Checkpoints
from pigbench.training.episodes import Episode
from pigbench.training.metrics import MetricsLog
from pigbench.training.provenance import package_versions, provenance
from pigbench.training.restore import agent_for
from pigbench.training.run import open_run

TRAIN = (
    "train gcbc --preset cpu --agent.batch-size 8 --agent.actor-hidden-sizes 8 "
    "--steps 1 --evaluate-every 1 --evaluation.episodes 1"
)


@pytest.fixture(scope="session")
def whole_campaign() -> bool:
    """Is all of a campaign asked for, or what `make test` has time for?"""
    return os.environ.get("PIGBENCH_CAMPAIGN") == "all"


@pytest.fixture(scope="session")
def prepared(tmp_path_factory) -> Path:
    """A folder with DATA and RUN."""
    folder = tmp_path_factory.mktemp("campaign")
    env = envs.make("cube-single")
    _write_data(folder / "DATA", env)
    _write_run(folder / "RUN", folder / "DATA", env)
    return folder


def _write_data(folder: Path, env: envs.CubeEnv) -> None:
    spec = Spec(
        environment=env.spec.name,
        policy="play",
        physics="exact",
        engine="mujoco",
        seed=0,
        episodes={"train": 2, "val": 1},
        episodes_per_shard=1,
        rows_per_episode=11,
        fields=collect.FIELDS,
        layout=dataset.sizes(env.layout),
        action_size=env.action_size,
        versions=package_versions(),
    )
    draws = np.random.default_rng(0)
    writer = Writer(folder, spec)
    for part in writer.missing():
        arrays = {
            field: draws.normal(size=(11, math.prod(shape))).astype(np.float32)
            for field, shape in collect.row_shapes(env).items()
        }
        writer.write(part, arrays | {"terminals": np.arange(11) == 10})


def _write_run(folder: Path, data_folder: Path, env: envs.CubeEnv) -> None:
    command = cli.parse(shlex.split(f"{TRAIN} --data {data_folder} --out {folder}"))
    data = dataset.load(data_folder)
    statistics = Statistics.of(Rows.from_split(data.split("train")).observations)
    agent = agent_for(env, command.method, command.agent_config, statistics)
    state = agents.create(agent, jax.random.key(0))
    origin = provenance(dataset=data_folder, dataset_digest=data.digest)
    run = open_run(folder, command.config(data, 0), origin, statistics)
    with Checkpoints(run.checkpoints_path) as checkpoints, MetricsLog(folder, step=0) as log:
        for step in (0, 1):
            checkpoints.save(state.replace(step=jax.numpy.int32(step)))
        log.write(1, {"actor/loss": 1.0})
    episodes.record(
        run.episodes_path,
        [
            Episode(1, number, task.name, 0, 0, {"success": number == 1, "length": 200})
            for number, task in enumerate(env.spec.tasks, start=1)
        ],
    )
