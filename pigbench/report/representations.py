"""Titles and looks of low-level representations."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from pigbench.report import stats
from pigbench.report.scoring import Cells
from pigbench.report.styles import BLACK, GREY, Style
from pigbench.support.grouping import grouped


class ShownRepresentation(NamedTuple):
    """A representation's title, the style of its curves, and how full of colour its boxes are."""

    title: str
    style: Style
    fill: float


REPRESENTATIONS = {
    "full": ShownRepresentation("full state", Style(GREY, "-"), fill=0.0),
    "joints_contacts": ShownRepresentation("joints and contacts", Style(BLACK, "-"), fill=0.35),
    "proprio": ShownRepresentation("proprioception", Style(BLACK, ":"), fill=0.8),
}


def representation(name: str) -> ShownRepresentation:
    """The representation of that name; an unknown name gets a default look."""
    return REPRESENTATIONS.get(name, ShownRepresentation(name, Style(BLACK, "-."), fill=0.35))


def by_representation(methods: Sequence[str], low_levels: Mapping[str, str | None]) -> list[str]:
    """`methods` with the variants of each in the order of `REPRESENTATIONS`."""
    places = {name: place for place, name in enumerate(dict.fromkeys(map(stats.base, methods)))}
    ranks = {name: rank for rank, name in enumerate(REPRESENTATIONS)}
    return sorted(
        methods,
        key=lambda method: (
            places[stats.base(method)],
            ranks.get(low_levels[method] or "", len(ranks)),
        ),
    )


def shown_names(low_levels: Mapping[str, str | None]) -> dict[str, str]:
    """The name of each method, given the representation that its low level sees.

    Variants are omitted if all variants of the method differ in what they see.
    """
    return {
        variant: name if len({low_levels[one] for one in variants}) == len(variants) else variant
        for name, variants in grouped(low_levels, stats.base).items()
        for variant in variants
    }


def has_low_levels(cells: Cells) -> bool:
    """Whether a method is hierarchical."""
    return any(result.representation for group in cells.values() for result in group)
