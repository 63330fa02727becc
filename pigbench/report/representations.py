"""How low-level representations are called and drawn."""

from typing import NamedTuple

from pigbench.report.styles import BLACK, GREY, Style


class Representation(NamedTuple):
    """The title of what a low level sees, how curves are drawn, and whether boxes are filled."""

    title: str
    style: Style
    filled: bool


REPRESENTATIONS = {
    "full": Representation("full state", Style(GREY, "-"), filled=False),
    "joints_contacts": Representation("joints and contacts", Style(BLACK, "-"), filled=True),
    "proprio": Representation("proprioception", Style(BLACK, ":"), filled=True),
}


def representation(name: str) -> Representation:
    """The representation of that name, known or not."""
    return REPRESENTATIONS.get(name, Representation(name, Style(BLACK, "-."), filled=True))
