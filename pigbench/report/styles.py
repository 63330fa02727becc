"""Looks of methods in all figures: colours, lines and hatches."""

import zlib
from collections.abc import Sequence
from typing import NamedTuple

from pigbench.report.stats import base

# Okabe and Ito's palette, which colour-blind readers can tell apart (jfly.uni-koeln.de/color). Its
# yellow is too light for a line on white, and is replaced by Tol's wine.
BLACK = "#000000"
ORANGE = "#E69F00"
SKY_BLUE = "#56B4E9"
GREEN = "#009E73"
WINE = "#882255"
BLUE = "#0072B2"
VERMILLION = "#D55E00"
PURPLE = "#CC79A7"
GREY = "#7F7F7F"
PALETTE = (BLACK, ORANGE, SKY_BLUE, GREEN, WINE, BLUE, VERMILLION, PURPLE)

HATCHES = {"-": "", "--": "////", "-.": "....", ":": "xxxx"}
"""The hatch of an area for each line style."""

VARIANTS = {
    "D": "||",
    "^": "--",
    "v": "\\\\\\\\",
    "s": "oo",
    "+": "++",
    "x": "..",
    "*": "**",
}
"""Markers on the lines of a method's variants, and the corresponding hatches of areas."""


class Style(NamedTuple):
    """A method's colour, line style and marker."""

    color: str
    line: str
    marker: str = "o"

    @property
    def hatch(self) -> str:
        """The filling of the method's bars and boxes."""
        return HATCHES[self.line] + VARIANTS.get(self.marker, "")


# Colours distinguish value learners and regularisers; lines, flat (solid) from hierarchical.
STYLES = {
    "gcbc": Style(BLACK, "-"),
    "crl": Style(BLACK, "-."),
    "hiql": Style(BLACK, "--"),
    "gciql": Style(WINE, "-"),
    "sharsa": Style(WINE, "--"),
    "dsharsa": Style(WINE, ":"),
    "gcivl": Style(BLUE, "-"),
    "eik-gcivl": Style(ORANGE, "-"),
    "hjb-gcivl": Style(VERMILLION, "-"),
    "h-flow-gcivl": Style(BLUE, "--"),
    "pi-h-flow-eik-gcivl": Style(ORANGE, "--"),
    "pi-h-flow-hjb-gcivl": Style(VERMILLION, "--"),
    "qrl": Style(GREEN, "-"),
    "eik-qrl": Style(SKY_BLUE, "-"),
    "hjb-qrl": Style(PURPLE, "-"),
    "h-flow-qrl": Style(GREEN, "--"),
    "pi-h-flow-eik-qrl": Style(SKY_BLUE, "--"),
    "pi-h-flow-hjb-qrl": Style(PURPLE, "--"),
}


def style(method: str) -> Style:
    """The method's own style, or else one determined by its name alone.

    A variant, named as in "method (variant)", adds a marker and a hatch to its method's style.
    """
    name = base(method)
    look = STYLES.get(name, Style(_pick(PALETTE, name), "-."))
    return (
        look if method == name else look._replace(marker=_pick(list(VARIANTS), method[len(name) :]))
    )


def _pick(choices: Sequence[str], name: str) -> str:
    return choices[zlib.crc32(name.encode()) % len(choices)]
