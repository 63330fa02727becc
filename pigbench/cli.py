"""The command line: `pigbench COMMAND ...`.

A command is chosen first, then its own fields are parsed. A user's error is reported as one line on
standard error, with exit status 2, or 75 if another process is writing the same files.
"""

import argparse
import contextlib
import importlib
import io
import os
import re
import sys
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import tyro

from pigbench import plugins
from pigbench.errors import UserError, lookup
from pigbench.support import interrupts, output


class Command(NamedTuple):
    """The location of a command's class, imported when it is chosen, and a summary.

    A command that `resumes` continues where it was cut off when it is run again; others start over.
    """

    module: str
    kind: str
    summary: str
    resumes: bool = False


COMMANDS = {
    "list": Command("listing", "List", "list environments or methods by name"),
    "generate": Command("generate", "Generate", "collect an offline data set", resumes=True),
    "data info": Command("data", "Info", "describe a data set"),
    "data verify": Command("data", "Verify", "find truncated or altered files of a data set"),
    "data filter": Command("data", "Filter", "keep a data set's good episodes", resumes=True),
    "data export": Command("data", "Export", "write a data set for OGBench, Minari or LeRobot"),
    "data card": Command("data", "Card", "write a data set's README for a hub"),
    "data push": Command("data", "Push", "put a data set on the Hugging Face hub", resumes=True),
    "data pull": Command("data", "Pull", "fetch a data set from the hub", resumes=True),
    "data import": Command(
        "data", "Import", "make a data set from OGBench's files or a robot's logs", resumes=True
    ),
    "data render": Command("render", "RenderData", "draw an episode of a data set as a film"),
    "train": Command("train", "Train", "train one method, with one seed or several", resumes=True),
    "evaluate": Command("evaluate", "Evaluate", "roll out a trained policy on every task"),
    "table": Command("report", "Table", "print success rates of runs as tables"),
    "suite": Command(
        "suite", "RunSuite", "train environments x methods x seeds as one job", resumes=True
    ),
    "suite status": Command("suite_status", "SuiteStatus", "show the progress of a suite"),
    "plot": Command("report", "Plot", "draw curves, bars, boxes or profiles of runs"),
    "report": Command("report", "Report", "make a page of runs or of a suite, for any browser"),
    "export": Command("export", "Export", "write a policy to share, which acts without pigbench"),
    "render": Command(
        "render", "Render", "draw a task as a picture, or a policy's episodes as a film"
    ),
    "analyze": Command(
        "analyze", "Analyze", "measure residuals of a value function by contact mode"
    ),
    "subgoals": Command(
        "subgoals", "SubgoalErrors", "measure how well a hierarchy reaches its subgoals"
    ),
    "parity": Command("parity", "Parity", "measure how close the simulations are to OGBench's"),
    "parity data": Command("parity", "ParityData", "measure how close data are to OGBench's own"),
    "parity policy": Command(
        "parity", "ParityPolicy", "compare a policy's success here and in OGBench"
    ),
    "bench generate": Command("bench", "Generate", "time data generation beside OGBench's"),
    "bench evaluate": Command("bench", "Evaluate", "time evaluation beside OGBench's"),
    "bench train": Command("bench", "Train", "time the updates of methods, side by side"),
    "bench rows": Command("bench", "Rows", "time training from rows on the device and on the disk"),
    "bench startup": Command(
        "bench", "Startup", "measure the processor time that commands take to start"
    ),
    "bench scale": Command(
        "scaling", "Scale", "time control steps by numbers of simulations and cubes"
    ),
    "bench memory": Command("scaling", "Memory", "show how much memory a control step needs"),
    "bench device": Command("device", "Device", "measure this machine's accelerator"),
    "toy": Command("toy", "Toy", "fit a known cost-to-go under each regulariser"),
}


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
    command = COMMANDS.get(_named(sys.argv[1:]) or "")
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


def parse(arguments: Sequence[str]) -> Any:
    """The command that `arguments` ask for. Raises UserError for a user's error."""
    files, arguments = _take_plugins(arguments)
    name, rest = _choose(arguments)
    _cache_compilations()
    plugins.load_installed()
    for file in files:
        plugins.load_file(file)
    module = importlib.import_module(f"pigbench.commands.{COMMANDS[name].module}")
    kind = getattr(module, COMMANDS[name].kind)
    return _parse(kind, rest, program=f"pigbench {name}")


def _take_plugins(arguments: Sequence[str]) -> tuple[list[Path], list[str]]:
    """The files given with `--plugin`, which every command takes, and the other arguments."""
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False, exit_on_error=False)
    parser.add_argument("--plugin", type=Path, action="append", default=[])
    try:
        known, others = parser.parse_known_args(arguments)
    except argparse.ArgumentError as error:
        raise UserError(f"{error}: the file of a plugin") from None
    return known.plugin, others


def _choose(arguments: Sequence[str]) -> tuple[str, list[str]]:
    """The command's name, of one word or two, and the arguments after it."""
    name = _named(arguments)
    if name is not None:
        return name, list(arguments[len(name.split()) :])
    words = [word for word in arguments[:2] if not word.startswith("-")]
    firsts = {name.split()[0] for name in COMMANDS}
    asked = " ".join(words if firsts.issuperset(words[:1]) else words[:1])
    if asked and asked not in firsts:
        lookup("command", COMMANDS, asked)
    print(_overview())
    sys.exit(0)


def _named(arguments: Sequence[str]) -> str | None:
    """The command named by the first two words, or else by the first; None if there is none."""
    names = (" ".join(arguments[:words]) for words in (2, 1))
    return next((name for name in names if name in COMMANDS), None)


def _cache_compilations() -> None:
    """Keep compiled programs between runs, in a default folder unless the user has set one."""
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "pigbench" / "jax"
    os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(cache))


def _overview() -> str:
    width = max(map(len, COMMANDS))
    lines = [
        "pigbench: offline goal-conditioned RL on contact-rich manipulation",
        "",
        "usage: pigbench COMMAND ... (pigbench COMMAND --help says more)",
        "",
        *(f"  {name:{width}}  {command.summary}" for name, command in COMMANDS.items()),
        "",
        "Every command takes --plugin FILE, a Python file that registers methods, environments",
        "or loggers of your own.",
    ]
    return "\n".join(lines)


def _parse(kind: Any, arguments: Sequence[str], *, program: str) -> Any:
    """The command's instance with its fields from `arguments`; `--help` prints and exits."""
    default = kind.defaults(arguments) if hasattr(kind, "defaults") else None
    complaint = io.StringIO()
    try:
        with contextlib.redirect_stderr(complaint):
            return tyro.cli(kind, default=default, args=arguments, prog=program)
    except SystemExit as exit_:
        if exit_.code in (0, None):
            raise
        raise UserError(f"{_one_line(complaint.getvalue())} (see {program} --help)") from None


def _one_line(box: str) -> str:
    """The text of a framed message of many lines, without its title and its pointer to the help."""
    lines = [re.sub(r"[╭╮╰╯│─]|\x1b\[[0-9;]*m", "", line).strip() for line in box.splitlines()]
    title, *text = filter(None, lines)
    pointer = next((i for i, line in enumerate(text) if line.startswith("For full helptext")), None)
    return " ".join(text[:pointer]) or title
