"""Titles and looks of low-level representations."""

from typing import NamedTuple

from pigbench.report.styles import BLACK, GREY, Style


class Representation(NamedTuple):
    """A representation's title, the style of its curves, and whether its boxes are filled."""

    title: str
    style: Style
    filled: bool


REPRESENTATIONS = {
    "full": Representation("full state", Style(GREY, "-"), filled=False),
    "joints_contacts": Representation("joints and contacts", Style(BLACK, "-"), filled=True),
    "proprio": Representation("proprioception", Style(BLACK, ":"), filled=True),
}


def representation(name: str) -> Representation:
    """The representation of that name; an unknown name gets a default look."""
    return REPRESENTATIONS.get(name, Representation(name, Style(BLACK, "-."), filled=True))
