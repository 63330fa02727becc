"""A small data set and a run on it, as commands would have left them, nothing being simulated; and
commands as processes of their own, which tests start, wait for, and kill.
"""

import json
import math
import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
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
from pigbench.evaluation import episodes
from pigbench.evaluation.episodes import Episode
from pigbench.provenance import package_versions, provenance
from pigbench.runs.checkpoints import Checkpoints
from pigbench.runs.metrics import MetricsLog
from pigbench.runs.run import open_run

TRAIN = (
    "train gcbc --preset cpu --agent.batch-size 8 --agent.actor-hidden-sizes 8 "
    "--steps 1 --evaluate-every 1 --evaluation.episodes 1"
)


class Server:
    """What `server.py` answers to; commands run in the tests' folder, with one thread of XLA."""

    def __init__(self, cache: Path) -> None:
        self._server = subprocess.Popen(
            [sys.executable, "-P", str(Path(__file__).with_name("server.py"))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env={
                **os.environ,
                "JAX_COMPILATION_CACHE_DIR": str(cache),
                "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
                "NPROC": "1",
            },
        )
        self._answer()

    def start(self, command: str, log: Path) -> int:
        """The process id of a `pigbench` command, whose output is added to `log`."""
        return int(self._ask([shlex.split(command), os.getcwd(), str(log)]))

    def wait(self, process: int) -> int:
        """Its exit status; that of a killed one is the signal's number, negative."""
        return int(self._ask(process))

    def run(self, command: str, log: Path) -> int:
        """From start to end."""
        return self.wait(self.start(command, log))

    def close(self) -> None:
        """Ends the server."""
        self._server.kill()
        self._server.communicate()

    def _ask(self, question: object) -> str:
        assert self._server.stdin is not None
        self._server.stdin.write(json.dumps(question) + "\n")
        self._server.stdin.flush()
        return self._answer()

    def _answer(self) -> str:
        assert self._server.stdout is not None
        answer = self._server.stdout.readline()
        assert answer, "the server has ended"
        return answer


@pytest.fixture
def place(prepared, tmp_path, monkeypatch) -> Path:
    """Copies of DATA and RUN, in the folder that commands run in."""
    for name in ("DATA", "RUN"):
        shutil.copytree(prepared / name, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="session")
def server(tmp_path_factory) -> Iterator[Server]:
    """Starts commands."""
    server = Server(tmp_path_factory.mktemp("compiled"))
    yield server
    server.close()


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
        layout=env.layout,
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
    agent = agents.build(command.method, command.agent, env.space, statistics=statistics)
    state = agents.create(agent, jax.random.key(0))
    origin = provenance(dataset=data_folder, dataset_digest=data.digest)
    config = command.config(
        0,
        environment=data.spec.environment,
        physics=data.spec.physics,
        dataset_digest=data.digest,
    )
    run = open_run(folder, config, origin, statistics)
    with Checkpoints(run.checkpoints_path) as checkpoints, MetricsLog(folder, step=0) as log:
        for step in (0, 1):
            checkpoints.save(state.replace(step=jax.numpy.int32(step)))
        log.write(1, {"actor/loss": 1.0})
    episodes.record(
        run.episodes_path,
        [
            Episode(
                1, number, task.name, 0, 0, env.backend, {"success": number == 1, "length": 200}
            )
            for number, task in enumerate(env.spec.tasks, start=1)
        ],
    )
