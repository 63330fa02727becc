"""Looks of methods in all figures: colours, lines and hatches."""

import zlib
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple, TypeVar

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

T = TypeVar("T")


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


# For methods without a style of their own. Representations have a black dotted line.
_SPARE = [
    look
    for line in ("-.", ":")
    for color in PALETTE
    if (look := Style(color, line)) not in {*STYLES.values(), Style(BLACK, ":")}
]


def styles(methods: Iterable[str]) -> dict[str, Style]:
    """The looks of methods that are drawn together, and of those whose variants they are.

    Methods have their own style, or else one that their name chooses among those that are left. A
    variant, named as in "method (variant)", adds a marker and a hatch to its method's style. No two
    look the same, unless there are more than looks.
    """
    methods = sorted(set(methods))
    looks: dict[str, Style] = {}
    for name in sorted({*map(base, methods)}, key=lambda name: (name not in STYLES, name)):
        looks[name] = STYLES.get(name) or _first_free(_spare(name), looks.values())
    for method in methods:
        if method not in looks:
            looks[method] = _first_free(_variants(method, looks), looks.values())
    return looks


def _first_free(choices: Sequence[Style], taken: Collection[Style]) -> Style:
    return next((look for look in choices if look not in taken), choices[0])


def _spare(name: str) -> list[Style]:
    """The looks for an unknown method; markers only when there is none without."""
    plain = _turned(_SPARE, name)
    return [look._replace(marker=marker) for marker in ("o", *VARIANTS) for look in plain]


def _variants(method: str, looks: Mapping[str, Style]) -> list[Style]:
    """The looks for a variant: first with the line of its method and a marker new to its colour."""
    name = base(method)
    own = looks[name]
    seen = {look.marker for look in looks.values() if look.color == own.color}
    markers = sorted(_turned(list(VARIANTS), method[len(name) :]), key=seen.__contains__)
    lines = sorted(HATCHES, key=lambda line: line != own.line)
    return [Style(own.color, line, marker) for line in lines for marker in markers]


def _turned(choices: Sequence[T], name: str) -> list[T]:
    """The choices in a cycle that starts where the name says."""
    start = zlib.crc32(name.encode()) % len(choices)
    return [*choices[start:], *choices[:start]]
