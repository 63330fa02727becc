"""The labels of rows that tell of an environment's methods or tasks, and of distances."""

from collections.abc import Iterable, Sequence

from pigbench.report.order import ordered
from pigbench.report.stats import Cell


def rows_of(cells: Iterable[Cell], order: Sequence[str]) -> dict[str, Cell]:
    """A row for each cell, by label: environments in order, then methods in order."""
    cells = set(cells)
    every = (
        Cell(method, environment)
        for environment in ordered({cell.environment for cell in cells}, order)
        for method in ordered({cell.method for cell in cells}, order)
    )
    return {row_label(cell.environment, cell.method): cell for cell in every if cell in cells}


def row_label(environment: str, name: str) -> str:
    """The label of an environment's method or task."""
    return f"{environment} {name}"


def centimetres(distance: float) -> str:
    """A distance given in metres."""
    return f"{100 * distance:g}"
