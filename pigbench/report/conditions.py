"""The conditions of results, in words, for captions and figures that compare them."""

from collections.abc import Callable, Collection, Iterable
from typing import NamedTuple

from pigbench.report.stats import Cell, Result
from pigbench.runs.run import RunConfig
from pigbench.support.grouping import grouped

_DIGITS = 12  # of a digest

Told = tuple[Cell, str]  # a cell and its value


class Condition(NamedTuple):
    """A condition of runs, and the value that captions omit; None: any, if all runs share it."""

    name: str
    of: Callable[[RunConfig], str]
    usual: str | None


CONDITIONS = (
    Condition("physics", lambda config: config.physics, "exact"),
    Condition("goals", lambda config: config.goals, "state"),
    Condition("preset", lambda config: config.preset, None),
)

# Names for cells with the same value, the shortest first.
_NAMES: tuple[Callable[[Cell], str], ...] = (
    lambda cell: cell.method,
    lambda cell: cell.environment,
    lambda cell: f"{cell.method} on {cell.environment}",
)


def remarks(results: Iterable[Result], *, always: Collection[str] = ()) -> list[str]:
    """The conditions that are not the usual ones for all, and those named in `always`.

    Also the environments in which methods learned from different data sets.
    """
    configs = [(Cell.of(result), result.run.config) for result in results]
    found = []
    for name, of, usual in CONDITIONS:
        told = {(cell, of(config)) for cell, config in configs}
        values = {value for _, value in told}
        is_usual = len(values) < 2 if usual is None else values <= {usual}
        if name in always or not is_usual:
            found.append(f"{name}: {_values_with_owners(told)}")
    data = ((cell, config.dataset_digest[:_DIGITS]) for cell, config in configs)
    return [*found, *unequal("data set", data)]


def unequal(name: str, told: Iterable[Told]) -> list[str]:
    """The methods of each value, for each environment in which values differ."""
    by_environment = grouped(sorted(set(told)), lambda one: one[0].environment)
    by_value = {
        environment: grouped(own, lambda one: one[1]) for environment, own in by_environment.items()
    }
    return [
        f"unequal {name} on {environment}: "
        + "; ".join(
            f"{value} ({', '.join(cell.method for cell, _ in own)})"
            for value, own in values.items()
        )
        for environment, values in by_value.items()
        if len(values) > 1
    ]


def _values_with_owners(told: Collection[Told]) -> str:
    """The values, and whose they are if there are several."""
    by_value = grouped(sorted(told), lambda one: one[1])
    if len(by_value) == 1:
        return next(iter(by_value))
    name = next((name for name in _NAMES if _determines_value(name, told)), _NAMES[-1])
    return ", ".join(
        f"{value} ({', '.join(dict.fromkeys(name(cell) for cell, _ in by_value[value]))})"
        for value in sorted(by_value)
    )


def _determines_value(name: Callable[[Cell], str], told: Collection[Told]) -> bool:
    """Whether all cells of the same name have the same value."""
    return all(
        len({value for _, value in own}) == 1
        for own in grouped(told, lambda one: name(one[0])).values()
    )
