"""Commands as processes of their own, which tests start, wait for, and kill."""

import contextlib
import json
import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path


class Server:
    """What `server.py` answers to; commands run in the folder `place`."""

    def __init__(self, place: Path, environment: Mapping[str, str]) -> None:
        self._server = subprocess.Popen(
            [sys.executable, "-P", str(Path(__file__).with_name("server.py"))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=place,
            env={**os.environ, **environment},
        )
        self._answer()

    def start(self, command: str, log: Path) -> int:
        """The process id of a `pigbench` command, whose output is added to `log`."""
        return int(self._ask([shlex.split(command), str(log)]))

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


@contextlib.contextmanager
def serving(place: Path) -> Iterator[Server]:
    """A server whose commands share a cache of compiled programs."""
    cache = place / "cache"
    server = Server(
        place,
        {
            "JAX_COMPILATION_CACHE_DIR": str(cache),
            "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
            "NPROC": "1",
        },
    )
    try:
        yield server
    finally:
        server.close()


def kill_group(process: int) -> None:
    """The process and those that it has started."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process, signal.SIGKILL)
