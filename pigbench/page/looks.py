"""How methods look on a page, by day and by night."""

from typing import NamedTuple

from pigbench.report.styles import BLACK, WINE, style

DARK = {BLACK: "#E4E4E4", WINE: "#C2608F"}
"""What takes the place of colours that cannot be told from a dark ground."""

DASHES = {"-": "", "--": "7 4", "-.": "7 3 1.5 3", ":": "1.5 3"}
"""Lengths of a line's strokes and gaps, in pixels."""

HATCHES = {"-": "blank", "--": "right_diagonal_line", "-.": "dot", ":": "cross"}
"""What a line is as the filling of a bar, as Bokeh calls it."""

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
"""Marks of evaluations, as Bokeh calls them; and the fillings of variants' bars."""

VARIANTS = {
    "D": "vertical_line",
    "^": "horizontal_line",
    "v": "left_diagonal_line",
    "s": "ring",
    "+": "cross",
    "x": "diagonal_cross",
    "*": "criss_cross",
}


class Shade(NamedTuple):
    """A colour on light ground and on dark."""

    light: str
    dark: str


class Look(NamedTuple):
    """How a method is drawn: colour, strokes and gaps of its line, mark, filling of its bars."""

    shade: Shade
    dash: str
    marker: str
    hatch: str


def look(method: str) -> Look:
    """The method's style in all pictures, as a page has it."""
    own = style(method)
    return Look(
        Shade(own.color, DARK.get(own.color, own.color)),
        DASHES[own.line],
        MARKERS[own.marker],
        VARIANTS.get(own.marker, HATCHES[own.line]),
    )
