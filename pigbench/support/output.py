"""Output in encodings that lack a character: a plain one replaces it, instead of an error."""

import codecs
import io
from typing import TextIO

_ERRORS = "pigbench.plain"
_PLAIN = {"±": "+/-", "–": "-"}


def write_plainly_where_needed(*streams: TextIO) -> None:
    """Make the streams accept any text from now on."""
    codecs.register_error(_ERRORS, _replace)
    for stream in streams:
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=_ERRORS)


def _replace(error: UnicodeError) -> tuple[str, int]:
    assert isinstance(error, UnicodeEncodeError)
    lacking = error.object[error.start : error.end]
    return "".join(_PLAIN.get(character, "?") for character in lacking), error.end
