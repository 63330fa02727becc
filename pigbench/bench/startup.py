"""Processor time that commands take to start, each in a process of its own."""

import os
import subprocess
import sys
from collections.abc import Sequence

from pigbench.errors import UserError


def seconds(arguments: Sequence[str]) -> float:
    """User plus system time of one `pigbench` command. Raises UserError if it fails."""
    before = os.times()
    ended = subprocess.run(
        [sys.executable, "-m", "pigbench", *arguments],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    after = os.times()
    if ended.returncode:
        raise UserError(f"pigbench {' '.join(arguments)} failed: {ended.stderr.strip()}")
    return (after.children_user - before.children_user) + (
        after.children_system - before.children_system
    )
