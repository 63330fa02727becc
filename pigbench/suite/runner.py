"""Running jobs as processes, several at a time, each with a log of its own."""

import contextlib
import os
import subprocess
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from pigbench.errors import BusyError
from pigbench.suite.jobs import Job
from pigbench.support import processes
from pigbench.support.lock import is_held
from pigbench.support.memory import SHARERS

FAILURE = "exit status"
"""The beginning of the last line in the log of a failed job."""

_POLL_SECONDS = 1.0
_PATIENCE_SECONDS = 10.0


class Process(Protocol):
    """A job that has been started, with the interface of `subprocess.Popen`."""

    returncode: int | Any

    def poll(self) -> int | None:
        """The exit status; None while it runs."""
        ...

    def wait(self, timeout: float, /) -> int | None:
        """Like `poll`, after waiting at most `timeout` seconds."""
        ...

    def terminate(self) -> None:
        """Ask it to end."""
        ...

    def kill(self) -> None:
        """End it."""
        ...


Start = Callable[[Job, Path, Sequence[str]], Process]
"""Starts a job, given its log and further options."""


def run(
    jobs: Iterable[Job],
    *,
    workers: int,
    log: Callable[[str], Path],
    options: Sequence[str] = (),
    report: Callable[[Sequence[str]], object] = lambda _: None,
    start: Start | None = None,
) -> Mapping[str, int]:
    """Run jobs, at most `workers` at once, and return their exit statuses by name.

    `log` gives the file to which a job's output is appended, `options` are added to every command,
    and `report` is called every second with the names of running jobs. An interruption also
    interrupts the jobs. A job whose folder is being written by another process, such as one that
    outlived a killed suite, counts as running, and is started when that process has ended; a job
    that ends because it met such a process is started again. `start` starts a job, by default as a
    process on this machine.
    """
    waiting = list(jobs)
    start = start or _on_this_machine(_environment(workers, len(waiting)))
    by_name = {job.name: job for job in waiting}
    ended: dict[str, int] = {}
    with _processes() as running:
        while waiting or running:
            for name in [name for name, process in running.items() if process.poll() is not None]:
                status = running.pop(name).returncode
                if status == BusyError.status:
                    waiting.insert(0, by_name[name])
                    continue
                ended[name] = status
                if status != 0:
                    _note_failure(log(name), status)
            held = [job for job in waiting if is_held(job.folder)]
            to_come = {*running, *(job.name for job in waiting)}
            free = [job for job in waiting if job not in held and job.after not in to_come]
            for job in free[: workers - len(running)]:
                waiting.remove(job)
                log(job.name).parent.mkdir(parents=True, exist_ok=True)
                running[job.name] = start(job, log(job.name), options)
            report((*running, *(job.name for job in held)))
            time.sleep(_POLL_SECONDS)
    return ended


@contextlib.contextmanager
def _processes() -> Iterator[dict[str, Process]]:
    """Processes by name; those left when the block ends are terminated."""
    running: dict[str, Process] = {}
    try:
        yield running
    finally:
        with contextlib.ExitStack() as every:  # even if one fails; last in, first out
            for process in running.values():
                every.callback(_see_ended, process)
            for process in running.values():
                every.callback(process.terminate)


def _see_ended(process: Process) -> None:
    try:
        process.wait(_PATIENCE_SECONDS)
    except subprocess.TimeoutExpired:
        process.kill()


def _note_failure(log: Path, status: int) -> None:
    with open(log, "a", encoding="utf-8") as file:
        file.write(f"{FAILURE} {status}\n")


def _environment(workers: int, jobs: int) -> Mapping[str, str]:
    """Environment variables of processes that run at once.

    Each has one XLA thread: one process per core does more than one process on all cores.
    """
    sharers = {SHARERS: str(max(1, min(workers, jobs)))}
    return sharers if workers == 1 else {"NPROC": os.environ.get("NPROC", "1")} | sharers


def _on_this_machine(environment: Mapping[str, str]) -> Start:
    return lambda job, log, options: processes.start(
        (*job.arguments, *options), log, environment=environment
    )
