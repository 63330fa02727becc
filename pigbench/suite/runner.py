"""Running jobs as processes, several at a time; what each says goes to a log of its own."""

import contextlib
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from pigbench.suite.jobs import Job
from pigbench.support.lock import is_held

_ONE_THREAD = {"NPROC": "1"}
"""One thread of XLA a process: as many processes as cores do more than one of all."""

FAILURE = "exit status"
"""How the line begins that ends the log of a job that failed."""

_POLL_SECONDS = 1.0
_PATIENCE_SECONDS = 10.0


class Process(Protocol):
    """A job that has been started, as `subprocess.Popen` has it."""

    returncode: int | Any

    def poll(self) -> int | None:
        """The exit status; None as long as it runs."""
        ...

    def wait(self, timeout: float, /) -> int | None:
        """As `poll`, after so many seconds at most."""
        ...

    def terminate(self) -> None:
        """Asks it to end."""
        ...

    def kill(self) -> None:
        """Ends it."""
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

    `log` names the file that a job's output is appended to, `options` follow every command, and
    `report` is told the names of jobs under way every second. When it is interrupted, so are
    those it runs. A job whose folder another process is writing, such as one that outlived a
    killed suite, counts as under way, and is run when that has ended. `start` starts a job, by
    default as a process of this machine.
    """
    start = start or partial(_start, alone=workers == 1)
    waiting = list(jobs)
    ended: dict[str, int] = {}
    with _processes() as running:
        while waiting or running:
            for name in [name for name, process in running.items() if process.poll() is not None]:
                ended[name] = running.pop(name).returncode
                if ended[name] != 0:
                    _note_failure(log(name), ended[name])
            held = [job for job in waiting if is_held(job.folder)]
            free = [job for job in waiting if job not in held]
            for job in free[: workers - len(running)]:
                waiting.remove(job)
                running[job.name] = start(job, log(job.name), options)
            report((*running, *(job.name for job in held)))
            time.sleep(_POLL_SECONDS)
    return ended


@contextlib.contextmanager
def _processes() -> Iterator[dict[str, Process]]:
    """Processes by name; those that are left when the block ends are told to end too."""
    running: dict[str, Process] = {}
    try:
        yield running
    finally:
        for process in running.values():
            process.terminate()
        for process in running.values():
            try:
                process.wait(_PATIENCE_SECONDS)
            except subprocess.TimeoutExpired:
                process.kill()


def _note_failure(log: Path, status: int) -> None:
    with open(log, "a", encoding="utf-8") as file:
        file.write(f"{FAILURE} {status}\n")


def _start(
    job: Job, log: Path, options: Sequence[str], *, alone: bool
) -> "subprocess.Popen[bytes]":
    log.parent.mkdir(parents=True, exist_ok=True)
    environment = os.environ if alone else _ONE_THREAD | os.environ
    with open(log, "ab") as file:
        return subprocess.Popen(
            [sys.executable, "-P", "-m", "pigbench", *job.arguments, *options],
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
            env=environment,
        )
