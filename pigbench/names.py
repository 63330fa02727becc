"""Names that users give, of methods and variants: they become folders, and text in LaTeX, Markdown
and figures.
"""

import re

from pigbench.errors import UserError

_LONGEST = 64
_NAME = re.compile(r"[A-Za-z0-9]+(?:[ ._=+,-][A-Za-z0-9]+)*")


def check(kind: str, name: str) -> str:
    """The name itself. Raises UserError unless it means itself wherever it is written."""
    if not _NAME.fullmatch(name) or len(name) > _LONGEST:
        raise UserError(
            f"{kind} is named {name!r}: choose letters and digits, {_LONGEST} characters at most, "
            "with single spaces or any of . _ = + , - between them"
        )
    return name
