"""User-given names of methods and variants, used in folders and as text in LaTeX, Markdown and
figures.
"""

import re
from collections.abc import Container

from pigbench.errors import UserError

_LONGEST = 64
_NAME = re.compile(r"[A-Za-z0-9]+(?:[ ._=+,-][A-Za-z0-9]+)*")


def check(kind: str, name: str) -> str:
    """Return the name. Raises UserError unless it can be written anywhere without escapes."""
    if not _NAME.fullmatch(name) or len(name) > _LONGEST:
        raise UserError(
            f"{kind} is named {name!r}: choose letters and digits, {_LONGEST} characters at most, "
            "with single spaces or any of . _ = + , - between them"
        )
    return name


def require_new(kind: str, name: str, table: Container[str]) -> None:
    """Raise UserError unless the name of something new to the table is valid and not taken.

    `kind` has its article, such as "a method".
    """
    check(kind, name)
    if name in table:
        raise UserError(
            f"{kind.partition(' ')[2]} {name!r} is already registered: choose another name"
        )
