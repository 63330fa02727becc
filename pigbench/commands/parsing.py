"""From arguments to a command: its name is chosen first, then its own fields are parsed."""

import argparse
import contextlib
import functools
import importlib
import io
import itertools
import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import tyro

from pigbench import plugins
from pigbench.commands.registry import COMMANDS, named
from pigbench.errors import UserError, lookup
from pigbench.support.typed import MAY_BE_EMPTY


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
    return parse_fields(kind, rest, program=f"pigbench {name}")


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
    name = named(arguments)
    if name is not None:
        return name, list(arguments[len(name.split()) :])
    words = [word for word in arguments[:2] if not word.startswith("-")]
    firsts = {name.split()[0] for name in COMMANDS}
    asked = " ".join(words if firsts.issuperset(words[:1]) else words[:1])
    if asked and asked not in firsts:
        lookup("command", COMMANDS, asked)
    print(_overview())
    sys.exit(0)


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
        "Every command takes --plugin FILE, a Python file that registers methods, environments,",
        "measures, physics engines or loggers of your own.",
    ]
    return "\n".join(lines)


def parse_fields(kind: Any, arguments: Sequence[str], *, program: str) -> Any:
    """The dataclass `kind` with its fields from `arguments`; `--help` prints and exits.

    Raises UserError for a user's error.
    """
    default = kind.defaults(arguments) if hasattr(kind, "defaults") else None
    complaint = io.StringIO()
    try:
        with contextlib.redirect_stderr(complaint):
            command = tyro.cli(
                kind,
                default=default,
                args=arguments,
                prog=program,
                config=(tyro.conf.AvoidSubcommands,),
            )
    except SystemExit as exit_:
        if exit_.code in (0, None):
            raise
        raise UserError(f"{_one_line(complaint.getvalue())} (see {program} --help)") from None
    if lacking := _lacking(command, arguments):
        raise UserError(f"{lacking} needs at least one value (see {program} --help)")
    return command


def _lacking(command: Any, arguments: Sequence[str]) -> str | None:
    """The first option that is given without the values that it takes, which would mean none.

    Fields with `MAY_BE_EMPTY` in their metadata need none.
    """
    for option, following in itertools.pairwise([*arguments, "--"]):
        if option.startswith("--") and following.startswith("--"):
            *places, name = option.removeprefix("--").replace("-", "_").split(".")
            holder = functools.reduce(lambda one, place: getattr(one, place, None), places, command)
            field = getattr(holder, "__dataclass_fields__", {}).get(name)
            if field and getattr(holder, name) == () and MAY_BE_EMPTY not in field.metadata:
                return option
    return None


def _one_line(box: str) -> str:
    """The text of a framed message of many lines, without its title and its pointer to the help."""
    lines = [re.sub(r"[╭╮╰╯│─]|\x1b\[[0-9;]*m", "", line).strip() for line in box.splitlines()]
    title, *text = filter(None, lines)
    pointer = next((i for i, line in enumerate(text) if line.startswith("For full helptext")), None)
    return " ".join(text[:pointer]) or title
