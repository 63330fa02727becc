"""Output where its encoding lacks a character: a plain one in its place, not an error."""

import codecs
import io
from typing import TextIO

_ERRORS = "pigbench.plain"
_PLAIN = {"±": "+/-", "–": "-"}


def write_plainly_where_needed(*streams: TextIO) -> None:
    """From now on the streams take every text."""
    codecs.register_error(_ERRORS, _replace)
    for stream in streams:
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=_ERRORS)


def _replace(error: UnicodeError) -> tuple[str, int]:
    assert isinstance(error, UnicodeEncodeError)
    lacking = error.object[error.start : error.end]
    return "".join(_PLAIN.get(character, "?") for character in lacking), error.end
