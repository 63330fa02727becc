"""The order of names in tables and figures."""

from collections.abc import Iterable, Sequence

from pigbench import agents, envs
from pigbench.report import stats


def registered() -> tuple[str, ...]:
    """The order of registration: methods, then environments."""
    return (*agents.names(), *envs.names())


def ordered(names: Iterable[str], order: Sequence[str]) -> list[str]:
    """`names` without repetition: first those in `order`, in that order, then others by alphabet.

    A method's variants, named as in "method (variant)", are placed where the method is.
    """
    rank = {name: number for number, name in enumerate(order)}
    return sorted(set(names), key=lambda name: (rank.get(stats.base(name), len(rank)), name))
