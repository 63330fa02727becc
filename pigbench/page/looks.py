"""Looks of methods on a page, in its light and its dark theme."""

from collections.abc import Iterable
from typing import NamedTuple

from pigbench.report.styles import BLACK, WINE, Style, styles

DARK = {BLACK: "#E4E4E4", WINE: "#C2608F"}
"""Replacements for colours that do not stand out from a dark ground."""

DASHES = {"-": "", "--": "7 4", "-.": "7 3 1.5 3", ":": "1.5 3"}
"""Lengths of a line's strokes and gaps in pixels."""

HATCHES = {"-": "blank", "--": "right_diagonal_line", "-.": "dot", ":": "cross"}
"""The filling of a bar for each line style, by Bokeh's name."""

MARKERS = {
    "o": "circle",
    "D": "diamond",
    "^": "triangle",
    "v": "inverted_triangle",
    "s": "square",
    "+": "plus",
    "x": "x",
    "*": "star",
}
"""Marks of evaluations, by Bokeh's names."""

GLYPHS = {
    "o": "",  # a legend shows those of variants
    "D": "◆",
    "^": "▲",
    "v": "▼",
    "s": "■",
    "+": "✚",
    "x": "✖",
    "*": "★",
}
"""The same marks as text."""

VARIANTS = {
    "D": "vertical_line",
    "^": "horizontal_line",
    "v": "left_diagonal_line",
    "s": "ring",
    "+": "spiral",
    "x": "diagonal_cross",
    "*": "criss_cross",
}
"""The filling of a bar for each marker of a method's variants, by Bokeh's name."""


class Shade(NamedTuple):
    """A colour on light ground and on dark ground."""

    light: str
    dark: str


class Look(NamedTuple):
    """A method's colour, its line's strokes and gaps, its mark, and its bars' filling.

    `glyph` is the mark as text; empty unless it tells a variant from its method.
    """

    shade: Shade
    dash: str
    marker: str
    glyph: str
    hatch: str


def looks(methods: Iterable[str]) -> dict[str, Look]:
    """The `styles` of methods that are shown together, in the form that a page needs."""
    return {method: _look(own) for method, own in styles(methods).items()}


def _look(own: Style) -> Look:
    return Look(
        Shade(own.color, DARK.get(own.color, own.color)),
        DASHES[own.line],
        MARKERS[own.marker],
        GLYPHS[own.marker],
        VARIANTS.get(own.marker, HATCHES[own.line]),
    )
