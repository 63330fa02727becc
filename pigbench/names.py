"""User-given names of methods and variants, used in folders and as text in LaTeX, Markdown and
figures.
"""

import re

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
