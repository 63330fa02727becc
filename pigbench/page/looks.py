"""Looks of methods on a page, in its light and its dark theme."""

from typing import NamedTuple

from pigbench.report.styles import BLACK, WINE, style

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

VARIANTS = {
    "D": "vertical_line",
    "^": "horizontal_line",
    "v": "left_diagonal_line",
    "s": "ring",
    "+": "cross",
    "x": "diagonal_cross",
    "*": "criss_cross",
}
"""The filling of a bar for each marker of a method's variants, by Bokeh's name."""


class Shade(NamedTuple):
    """A colour on light ground and on dark ground."""

    light: str
    dark: str


class Look(NamedTuple):
    """A method's colour, its line's strokes and gaps, its mark, and its bars' filling."""

    shade: Shade
    dash: str
    marker: str
    hatch: str


def look(method: str) -> Look:
    """The method's style in all pictures, in the form that a page needs."""
    own = style(method)
    return Look(
        Shade(own.color, DARK.get(own.color, own.color)),
        DASHES[own.line],
        MARKERS[own.marker],
        VARIANTS.get(own.marker, HATCHES[own.line]),
    )
