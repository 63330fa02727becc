"""Tasks on a Ray cluster of this machine alone, whose processes are killed."""

import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from pigbench import cli, envs
from pigbench.cluster import Cluster, RemoteProcess, Tasks, _most_on_one
from pigbench.data import dataset
from pigbench.errors import UserError
from pigbench.suite import runner
from pigbench.suite.jobs import Job

LOCAL = Cluster("local", cpus_per_task=0.5)
MINE = """
import dataclasses
from pigbench import envs
envs.register(dataclasses.replace(envs.SPECS["cube-single"], name="mine"))
"""
SMALL = "--episodes 3 --episodes-per-shard 1 --validation-episodes 0 --episode-length 11"


@pytest.fixture
def tasks():
    with LOCAL.connected() as tasks:
        yield tasks


def test_a_task_whose_process_is_killed_is_started_again(tasks: Tasks, tmp_path, monkeypatch):
    def attempt(name: str) -> int:
        """The first attempt waits to be killed."""
        place = tmp_path / name
        if not place.exists():
            place.write_text(str(os.getpid()))
            time.sleep(600)
        return len(name)

    victim = tasks.start(attempt, "victim")
    while not (tmp_path / "victim").exists() or not (tmp_path / "victim").read_text():
        time.sleep(0.05)
    assert not tasks.finished(victim)
    os.kill(int((tmp_path / "victim").read_text()), signal.SIGKILL)
    assert tasks.result(victim) == len("victim")

    (tmp_path / "a").touch()
    assert dict(tasks.results(attempt, {"one": ("a",), "two": ("victim",)})) == {"one": 1, "two": 6}

    def refuse() -> None:
        raise UserError("no")

    with pytest.raises(UserError, match="no"):
        tasks.result(tasks.start(refuse))

    killer = tmp_path / "killer.py"
    killer.write_text("import os, signal; os.kill(os.getppid(), signal.SIGKILL)")
    monkeypatch.setitem(tasks._options, "max_retries", 0)
    jobs = [
        Job("lost", tmp_path / "lost", ("list", "envs", "--plugin", str(killer))),
        *(Job(name, tmp_path / name, ("list", name)) for name in ("envs", "nonsense")),
    ]
    logs = {job.name: tmp_path / "logs" / f"{job.name}.log" for job in jobs}
    ended = runner.run(
        jobs,
        workers=3,
        log=logs.__getitem__,
        start=lambda *job: RemoteProcess(tasks, *job),
    )
    assert ended == {"lost": 1, "envs": 0, "nonsense": 2}
    assert "pigbench: the Ray cluster lost a task: " in logs["lost"].read_text()
    assert "cube-octuple" in logs["envs"].read_text()
    assert "unknown topic 'nonsense'" in logs["nonsense"].read_text()


def test_a_data_set_has_the_same_bytes(tmp_path, monkeypatch):
    """Of an environment that a plugin brings."""
    monkeypatch.setattr(envs, "SPECS", dict(envs.SPECS))
    plugin = tmp_path / "mine.py"
    plugin.write_text(MINE)
    for out, more in (("here", ""), ("there", "--ray local --cpus-per-task 2")):
        command = f"generate mine --plugin {plugin} --out {tmp_path / out} {SMALL} {more}"
        cli.run(command.split())

    def contents(folder: Path) -> dict[str, bytes]:
        paths = (path for path in folder.rglob("*") if path.is_file())
        return {str(path.relative_to(folder)): path.read_bytes() for path in paths}

    assert contents(tmp_path / "there") == contents(tmp_path / "here")
    assert dataset.verify(tmp_path / "there") == []


@pytest.fixture(scope="module")
def token(tmp_path_factory) -> dict[str, str]:
    """The environment of one who has a token."""
    file = tmp_path_factory.mktemp("ray") / "auth_token"
    file.write_text(64 * "7")
    others = {name: value for name, value in os.environ.items() if name != "RAY_AUTH_MODE"}
    return others | {"RAY_AUTH_TOKEN_PATH": str(file)}


@pytest.fixture(scope="module")
def asking(token) -> Iterator[str]:
    """The address of a cluster that asks for the token."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        host, port = server.getsockname()
    command = f"start --head --node-ip-address={host} --port={port} --num-cpus=1 --block"
    quiet = "--include-dashboard=false --disable-usage-stats"
    ray = subprocess.Popen(
        [Path(sys.executable).with_name("ray"), *command.split(), *quiet.split()],
        env=token | {"RAY_AUTH_MODE": "token"},
        stdout=subprocess.PIPE,
        text=True,
    )
    assert ray.stdout and any("Ray runtime started" in line for line in ray.stdout)
    yield f"{host}:{port}"
    ray.terminate()
    ray.communicate()


def used(cluster: str, environment: dict[str, str]) -> subprocess.CompletedProcess[str]:
    """Prints the address of the cluster that a task runs on."""
    script = f"""
from pigbench.cluster import Cluster
with Cluster({cluster!r}).connected() as tasks:
    import ray
    print(tasks.result(tasks.start(lambda: ray.get_runtime_context().gcs_address)))
"""
    command = [sys.executable, "-c", script]
    return subprocess.run(command, env=environment, capture_output=True, text=True)


def port(address: str) -> int:
    """Hosts have several names."""
    return int(address.rpartition(":")[2])


def test_a_token_is_presented_if_one_says_so(asking, token):
    done = used(asking, token | {"RAY_AUTH_MODE": "token"})
    assert port(done.stdout) == port(asking), done.stderr
    refused = used(asking, token)
    assert not refused.stdout
    said = f"no Ray cluster answers at {asking}: .*set RAY_AUTH_MODE=token if it asks"
    assert re.search(said, refused.stderr)


def test_a_local_cluster_is_none_that_runs_already(asking, token):
    done = used("local", token | {"RAY_ADDRESS": asking})
    assert done.stdout, done.stderr
    assert port(done.stdout) != port(asking)


def test_a_cluster_that_is_not_there_and_resources_that_cannot_be_are_refused():
    with pytest.raises(UserError, match=r"no Ray cluster answers at 127\.0\.0\.1:1"):
        Cluster("127.0.0.1:1").connected().__enter__()
    with pytest.raises(UserError, match=r"no Ray cluster answers at a\.\.b:80: .*label"):
        Cluster("a..b:80").connected().__enter__()
    with pytest.raises(UserError, match="cpus_per_task is -1"):
        Cluster("local", cpus_per_task=-1)
    with pytest.raises(UserError, match="gpus_per_task has no effect without ray: leave it out"):
        Cluster(gpus_per_task=0)


@pytest.mark.parametrize(
    ("cpus", "gpus", "most"), [(4, 1, 2), (4, 0, 4), (0.5, 0, 32), (0, 0.5, 4)]
)
def test_a_machine_has_as_many_tasks_as_its_scarcest_resource_allows(cpus, gpus, most):
    nodes = [{"Resources": {}}, {"Resources": {"CPU": 16.0, "GPU": 2.0, "memory": 1e9}}]
    assert _most_on_one(nodes, Cluster("any", cpus, gpus)) == most
