"""The command line: `pigbench COMMAND ...`, and that of scripts.

A user's error is reported as one line on standard error, with exit status 2, or 75 if another
process is writing the same files.
"""

import contextlib
import os
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NoReturn

from pigbench import settings
from pigbench.commands.parsing import parse, parse_fields
from pigbench.commands.registry import COMMANDS, named
from pigbench.errors import UserError
from pigbench.support import interrupts, output


def main() -> None:
    """Run the command of `sys.argv`; the exit status is that of a user's error."""
    with _reporting("pigbench", _farewell):
        run(sys.argv[1:])


def script(kind: Callable[..., Any]) -> None:
    """Run a script as if it were a command: `kind` is a dataclass with a method `run`.

    Its fields are the script's options.
    """
    program = Path(sys.argv[0]).name
    with _reporting(program, lambda: f"{program}: interrupted"):
        _run(parse_fields(kind, sys.argv[1:], program=program))


@contextlib.contextmanager
def _reporting(program: str, farewell: Callable[[], str]) -> Iterator[None]:
    """Whatever ends the block is said in a line, and ends the process with an exit status."""
    warnings.formatwarning = _format_warning
    output.write_plainly_where_needed(sys.stdout, sys.stderr)
    with interrupts.leaving_at_once(farewell):
        try:
            try:
                yield
            finally:
                sys.stdout.flush()
        except UserError as error:
            _refuse(program, str(error), error.status)
        except BrokenPipeError:
            _discard_output()
        except OSError as error:  # the system refuses what a command must read or write
            _discard_output()
            _refuse(program, f"{error.filename or 'output'}: {error.strerror or error}")


def _refuse(program: str, complaint: str, status: int = UserError.status) -> NoReturn:
    print(f"{program}: {' '.join(complaint.split())}", file=sys.stderr)
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
    _run(parse(arguments))


def _run(command: Any) -> None:
    with _jax_defaults():
        command.run()


def _jax_defaults() -> contextlib.AbstractContextManager[None]:
    """JAX's own defaults while the command runs, which may be the first to import JAX."""
    if "jax" in sys.modules:
        return settings.jax_defaults()
    settings.start_with_jax_defaults()
    return contextlib.nullcontext()
