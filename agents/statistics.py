"""How the coordinates of an observation are distributed in the data: what standardising needs."""

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np

from pigbench.errors import UserError

DEVIATION_FLOOR = 0.02
"""The least deviation that is divided by: a coordinate that hardly moves is noise, not signal."""

_ROWS = 1_000_000  # read at most; the statistics of more are the same to three digits


class Table(Protocol):
    """What rows can be taken from, wherever they are."""

    def __len__(self) -> int: ...

    def __getitem__(self, rows: slice, /) -> Any: ...


class Statistics(NamedTuple):
    """Of n coordinates, float32 (n,) each: constants, like the data that they are taken from."""

    mean: np.ndarray
    deviation: np.ndarray  # at least `DEVIATION_FLOOR`

    @classmethod
    def of(cls, observations: Table) -> "Statistics":
        """Of the rows of `observations` (N, n); of evenly spaced ones where there are very many."""
        stride = -(-len(observations) // _ROWS)
        rows = np.asarray(observations[::stride], np.float64)
        deviation = np.maximum(rows.std(axis=0), DEVIATION_FLOOR)
        return cls(rows.mean(axis=0).astype(np.float32), deviation.astype(np.float32))

    @classmethod
    def standard(cls, size: int) -> "Statistics":
        """Of `size` coordinates that are standardised already."""
        return cls(np.zeros(size, np.float32), np.ones(size, np.float32))

    def select(self, parts: Mapping[str, slice]) -> "Statistics":
        """Of some terms of an observation alone, in their order."""
        return Statistics(
            *(np.concatenate([values[part] for part in parts.values()]) for values in self)
        )


def require(statistics: Statistics | None, what: str) -> Statistics:
    """`statistics`; `UserError` saying that `what` needs them if there are none."""
    if statistics is None:
        raise UserError(f"{what} needs the statistics of a data set: build the agent with them")
    return statistics
