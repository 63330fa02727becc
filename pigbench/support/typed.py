"""The command of this process, as one would type it."""

import shlex
import sys
from pathlib import Path


def command() -> str:
    """The program's name, without its folder, and its arguments."""
    program, *arguments = sys.argv
    name = Path(program).name
    return shlex.join(["pigbench" if name == "__main__.py" else name, *arguments])
