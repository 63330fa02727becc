"""Titles and looks of low-level representations."""

from collections.abc import Mapping
from typing import NamedTuple

from pigbench.report import stats
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


def called(seen: Mapping[str, str | None]) -> dict[str, str]:
    """The name of each method, given the representation that it sees.

    Variants are omitted if all variants of the method differ in what they see.
    """
    return {
        variant: name if len({seen[one] for one in variants}) == len(variants) else variant
        for name, variants in stats.grouped(seen, stats.base).items()
        for variant in variants
    }
