"""The command line: `pigbench COMMAND ...`.

A user's error is reported as one line on standard error, with exit status 2, or 75 if another
process is writing the same files.
"""

import contextlib
import importlib
import os
import sys
import warnings
from collections.abc import Sequence
from typing import NoReturn

from pigbench.commands.parsing import parse
from pigbench.commands.registry import COMMANDS, named
from pigbench.errors import UserError
from pigbench.support import interrupts, output


def main() -> None:
    """Run the command of `sys.argv`; the exit status is that of a user's error."""
    warnings.formatwarning = _format_warning
    output.write_plainly_where_needed(sys.stdout, sys.stderr)
    with interrupts.leaving_at_once(_farewell):
        try:
            try:
                run(sys.argv[1:])
            finally:
                sys.stdout.flush()
        except UserError as error:
            _refuse(str(error), error.status)
        except BrokenPipeError:
            _discard_output()
        except OSError as error:  # the system refuses what a command must read or write
            _discard_output()
            _refuse(f"{error.filename or 'output'}: {error.strerror or error}")


def _refuse(complaint: str, status: int = UserError.status) -> NoReturn:
    print(f"pigbench: {' '.join(complaint.split())}", file=sys.stderr)
    sys.exit(status)


def _discard_output() -> None:
    """Discard pending output that nobody reads, so that Python does not retry when it exits."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _farewell() -> str:
    """The message of an interrupted command."""
    command = COMMANDS.get(named(sys.argv[1:]) or "")
    how = "go on" if command is not None and command.resumes else "begin anew"
    return f"pigbench: interrupted; run the same command again to {how}"


def _format_warning(message: Warning | str, *_: object) -> str:
    return f"pigbench: {' '.join(str(message).split())}\n"


def run(arguments: Sequence[str]) -> None:
    """Parse and run one command. Raises UserError for a user's error."""
    command = parse(arguments)
    with _jax_defaults():
        command.run()


def _jax_defaults() -> contextlib.AbstractContextManager[None]:
    """The defaults of `pigbench.settings` if the command has imported JAX, else none."""
    if "jax" not in sys.modules:
        return contextlib.nullcontext()
    return importlib.import_module("pigbench.settings").jax_defaults()
