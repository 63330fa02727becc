"""Starts commands by forking a process that has imported them: real processes that start cheaply.

Run as a script. A line on standard input is JSON: the arguments, the folder to run in, and the
file for what the command says; the answer is its process id. Another is a process id: the answer
is the exit status, once it has ended. Nothing here lets JAX start, so that forking is safe.
"""

import json
import os
import sys
import warnings
from collections.abc import Sequence

from pigbench import cli
from pigbench.commands import (  # noqa: F401  imported here, not in each process
    analyze,
    data,
    evaluate,
    generate,
    render,
    report,
    suite,
    train,
)


def start(arguments: Sequence[str], folder: str, log: str) -> int:
    """The process of a command, which leads a group of its own."""
    child = os.fork()
    if child:
        return child
    os.setsid()
    os.chdir(folder)
    output = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    for descriptor in (sys.stdout.fileno(), sys.stderr.fileno()):
        os.dup2(output, descriptor)
    os.dup2(os.open(os.devnull, os.O_RDONLY), sys.stdin.fileno())
    sys.argv = ["pigbench", *arguments]
    status = 0
    try:
        cli.main()
    except SystemExit as stop:
        status = stop.code if isinstance(stop.code, int) else int(stop.code is not None)
    except BaseException:
        sys.excepthook(*sys.exc_info())
        status = 1
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


def main() -> None:
    """Answers until the input ends."""
    warnings.filterwarnings("ignore", message=".*fork.*")
    print("ready", flush=True)
    while line := sys.stdin.readline():
        asked = json.loads(line)
        if isinstance(asked, int):
            answer = os.waitstatus_to_exitcode(os.waitpid(asked, 0)[1])
        else:
            answer = start(*asked)
        print(answer, flush=True)


if __name__ == "__main__":
    main()
