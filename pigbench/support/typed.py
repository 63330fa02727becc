"""Commands as one would type them."""

import shlex
import sys
from pathlib import Path

MAY_BE_EMPTY = "may be empty"
"""Metadata of a command's field whose option, given without values, means none at all."""


def command() -> str:
    """The command of this process: the program's name, without its folder, and its arguments."""
    program, *arguments = sys.argv
    name = Path(program).name
    return shlex.join(["pigbench" if name == "__main__.py" else name, *arguments])


def complete(folder: Path, *, seen_by: str) -> str:
    """The line with which a command ends that has completed `folder`, and the command to see it."""
    return f"{folder} is complete; see it with: pigbench {seen_by} {shlex.quote(str(folder))}"
