"""`pigbench` commands in processes of their own."""

import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType


def command_line(arguments: Sequence[str]) -> list[str]:
    """The program and its arguments; the folder where it runs hides none of its modules."""
    return [sys.executable, "-P", "-m", "pigbench", *arguments]


def start(
    arguments: Sequence[str],
    log: Path,
    *,
    folder: str | None = None,
    environment: Mapping[str, str] = MappingProxyType({}),
) -> "subprocess.Popen[bytes]":
    """Start a command whose output is appended to `log`.

    It runs in `folder`, by default this process's, with further variables in its `environment`.
    """
    with open(log, "ab") as file:
        return subprocess.Popen(
            command_line(arguments),
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
            cwd=folder,
            env=os.environ | environment,
        )
