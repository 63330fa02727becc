"""The one kind of error that a user can fix, and the checks that raise it.

Every layer of the package may import this module; it imports none of them.
"""

import difflib
import math
import os
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

T = TypeVar("T")


class UserError(Exception):
    """Something the user gave is wrong. The message says what is wrong and what would be right.

    The command line prints it as one line and exits with its status.
    """

    status = 2


class BusyError(UserError):
    """Another process is writing the same files: the same command will work later."""

    status = os.EX_TEMPFAIL


def unknown_name(kind: str, name: str, known: Iterable[str]) -> UserError:
    """The error for a name that is not in `known`: nearest match first, then the whole list."""
    known = sorted(known)
    nearest = difflib.get_close_matches(name, known, n=1, cutoff=0.4)
    suggestion = f"did you mean {nearest[0]!r}? " if nearest else ""
    return UserError(f"unknown {kind} {name!r}: {suggestion}known are {', '.join(known)}")


def lookup(kind: str, table: Mapping[str, T], name: str) -> T:
    """`table[name]`. Raises the `unknown_name` error if there is none."""
    if name not in table:
        raise unknown_name(kind, name, table)
    return table[name]


def unknown_own(kind: str, name: str, known: Iterable[str]) -> UserError:
    """Like `unknown_name`, of what a user's own file can add to."""
    return UserError(f"{unknown_name(kind, name, known)} (for one of your own, add --plugin FILE)")


def lookup_own(kind: str, table: Mapping[str, T], name: str) -> T:
    """Like `lookup`, in a table to which a user's own file can add."""
    if name not in table:
        raise unknown_own(kind, name, table)
    return table[name]


def require(config: object, holds: Callable[[Any], bool], rule: str, *fields: str) -> None:
    """Raise `UserError` for the first of `fields` whose value does not satisfy `holds`.

    Neither do numbers that are not finite.
    """
    for field in fields:
        value = getattr(config, field)
        if isinstance(value, float) and not math.isfinite(value):
            raise UserError(f"{field} is {value}: it must be a finite number")
        if not holds(value):
            raise UserError(f"{field} is {value}: it must be {rule}")


def require_left_out(config: object, where: str, *fields: str) -> None:
    """Raise `UserError` for the first of `fields` that was given, for it has no effect `where`.

    Fields that were not given are None, False or empty.
    """
    for field in fields:
        value = getattr(config, field)
        if value is not None and value is not False and value != ():
            raise UserError(f"{field} has no effect {where}: leave it out")
