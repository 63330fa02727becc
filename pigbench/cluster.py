"""Ray, an optional extra: runs work as tasks on a cluster's machines, or on this one's processes.

A task whose process or machine dies is restarted elsewhere.
"""

import contextlib
import math
import os
import socket
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from pigbench.errors import UserError, require, require_left_out
from pigbench.suite.jobs import Job
from pigbench.support import processes
from pigbench.support.extras import required
from pigbench.support.lock import is_held
from pigbench.support.memory import SHARERS

Result = TypeVar("Result")

_LOCAL = "local"  # Ray's own word; without an address, it would join a cluster that runs already
_RETRIES = 20
_IN_FLIGHT = 2  # tasks submitted at a time, per task that can run
_POLL_SECONDS, _PATIENCE_SECONDS = 0.5, 10.0
_AUTHENTICATION = "RAY_AUTH_MODE"


@dataclass(frozen=True)
class Cluster:
    """Where tasks run, and what each may take there."""

    ray: str | None = None
    """Ray cluster that shares the work: its address, or local for one on this machine alone."""
    cpus_per_task: float | None = None
    """Processor cores for each task on the cluster, by default 1."""
    gpus_per_task: float | None = None
    """GPUs for each task on the cluster, by default none."""

    def __post_init__(self) -> None:
        amounts = "cpus_per_task", "gpus_per_task"
        require(self, lambda x: x is None or 0 <= x < math.inf, "at least 0", *amounts)
        if self.ray is None:
            require_left_out(self, "without ray", *amounts)

    @property
    def cpus(self) -> float:
        """Processor cores for each task."""
        return 1 if self.cpus_per_task is None else self.cpus_per_task

    @property
    def gpus(self) -> float:
        """GPUs for each task."""
        return self.gpus_per_task or 0

    @property
    def arguments(self) -> tuple[str, ...]:
        """The arguments that make a command run on the same cluster."""
        if self.ray is None:
            return ()
        cpus, gpus = str(self.cpus), str(self.gpus)
        return ("--ray", self.ray, "--cpus-per-task", cpus, "--gpus-per-task", gpus)

    @contextlib.contextmanager
    def connected(self) -> Iterator["Tasks"]:
        """Tasks on the cluster while the block lasts. Raises UserError if no cluster answers."""
        ray = _ray()
        _knock(self.ray)
        try:
            ray.init(
                address=self.ray,
                include_dashboard=False if self.ray == _LOCAL else None,
                log_to_driver=False,
                logging_level="error",
            )
        except (OSError, RuntimeError, ValueError, ray.exceptions.AuthenticationError) as error:
            raise UserError(f"no Ray cluster answers at {self.ray}: {error}{_hint()}") from None
        try:
            yield Tasks(ray, self)
        finally:
            ray.shutdown()


class Tasks:
    """Runs functions on the connected cluster."""

    def __init__(self, ray: Any, cluster: Cluster) -> None:
        self._ray = ray
        # XLA's flags affect results, so they are the same everywhere; threads follow the cores.
        environment = {"XLA_FLAGS": os.environ.get("XLA_FLAGS", "")}
        environment["NPROC"] = str(max(1, math.floor(cluster.cpus)))
        environment[SHARERS] = str(max(1, _most_on_one(ray.nodes(), cluster)))
        self._options = {
            "num_cpus": cluster.cpus,
            "num_gpus": cluster.gpus,
            "max_retries": _RETRIES,
            "runtime_env": {"env_vars": environment},
        }
        cores = ray.cluster_resources().get("CPU", 1)
        self._most = max(1, int(_IN_FLIGHT * cores / max(cluster.cpus, 1)))

    def start(self, function: Callable[..., Result], *arguments: Any) -> Any:
        """Submit `function(*arguments)`; returns a task for `finished`, `result` and `cancel`."""
        return self._ray.remote(**self._options)(function).remote(*arguments)

    def finished(self, task: Any, *, seconds: float = 0) -> bool:
        """Whether the task has ended, waiting up to `seconds` for it."""
        return bool(self._ray.wait([task], timeout=seconds, fetch_local=False)[0])

    def result(self, task: Any) -> Any:
        """The task's return value. Raises its exception, or UserError if it could not be run."""
        try:
            return self._ray.get(task)
        except self._ray.exceptions.RayTaskError as error:
            raise error.cause from None
        except self._ray.exceptions.RayError as error:
            raise UserError(f"the Ray cluster lost a task: {error}") from None

    def cancel(self, task: Any) -> None:
        """Cancel the task; its process, if it has begun, ends at once."""
        self._ray.cancel(task, force=True)

    def results(
        self, function: Callable[..., Result], asked: Mapping[str, tuple[Any, ...]]
    ) -> Iterator[tuple[str, Result]]:
        """Yield `function(*arguments)` by name, in order of completion; few are held at once."""
        waiting, running = list(asked), {}
        while waiting or running:
            while waiting and len(running) < self._most:
                name = waiting.pop(0)
                running[self.start(function, *asked[name])] = name
            (ended, *_), _ = self._ray.wait(list(running))
            yield running.pop(ended), self.result(ended)


class RemoteProcess:
    """A `pigbench` command as a task, with the interface of a process on this machine."""

    def __init__(self, tasks: Tasks, job: Job, log: Path, options: Sequence[str]) -> None:
        self._tasks, self._log = tasks, log
        arguments = (*job.arguments, *options)
        folder, log = job.folder.absolute(), log.absolute()
        self._task = tasks.start(_run, arguments, folder, log, os.getcwd())
        self.returncode: int | None = None

    def poll(self) -> int | None:
        """The exit status; None while it runs. A lost task's is 1, and its log says so."""
        if self.returncode is None and self._tasks.finished(self._task):
            try:
                self.returncode = self._tasks.result(self._task)
            except (UserError, OSError) as error:
                with open(self._log, "a", encoding="utf-8") as file:
                    file.write(f"pigbench: {' '.join(str(error).split())}\n")
                self.returncode = 1
        return self.returncode

    def wait(self, seconds: float) -> int | None:
        """Like `poll`, after waiting at most so many seconds."""
        self._tasks.finished(self._task, seconds=seconds)
        return self.poll()

    def terminate(self) -> None:
        """End the task."""
        if self.poll() is None:
            self._tasks.cancel(self._task)
            self.returncode = -1

    kill = terminate


def _run(arguments: Sequence[str], folder: Path, log: Path, place: str) -> int:
    """Run a command on the cluster; returns its exit status. Its output is appended to `log`.

    A restarted task first waits for the command that its predecessor left running.
    """
    if not log.parent.is_dir():
        raise UserError(f"{log.parent} is not on every machine of the cluster: share the folder")
    while is_held(folder):
        time.sleep(_POLL_SECONDS)
    command = processes.start(arguments, log, folder=place)
    try:
        return command.wait()
    finally:
        command.kill()  # if this task is ended first


def _most_on_one(nodes: Sequence[Mapping[str, Any]], cluster: Cluster) -> int:
    """How many tasks a machine of the cluster has at once, at most."""
    per_task = {"CPU": cluster.cpus or 1, "GPU": cluster.gpus}
    return max(
        min(
            math.floor(node["Resources"].get(kind, 0) / amount)
            for kind, amount in per_task.items()
            if amount
        )
        for node in nodes
    )


def _knock(address: str | None) -> None:
    """Raise UserError if nothing listens there: Ray itself would retry for minutes."""
    host, colon, port = (address or "").rpartition(":")
    if colon and port.isdigit():
        place = host.removeprefix("ray://"), int(port)
        try:
            socket.create_connection(place, _PATIENCE_SECONDS).close()
        except (OSError, UnicodeError) as error:
            raise UserError(f"no Ray cluster answers at {address}: {error}") from None


def _hint() -> str:
    if _AUTHENTICATION in os.environ:
        return ""
    return f" (set {_AUTHENTICATION}=token if it asks for the token in ~/.ray/auth_token)"


def _ray() -> Any:
    # Ray would report its usage statistics over the network.
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    return required("ray", extra="ray")[0]
