"""Statistics of the observations in the data, as needed for standardisation."""

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np
from jaxtyping import Float32

from pigbench.errors import UserError

DEVIATION_FLOOR = 0.02
"""The smallest deviation to divide by, in the observation's units: what hardly moves is noise."""

_ROWS = 1_000_000  # read at most; the statistics of more rows are the same to three digits


class Table(Protocol):
    """Anything that rows can be sliced from, in memory or on disk."""

    def __len__(self) -> int: ...

    def __getitem__(self, rows: slice, /) -> Any: ...


class Statistics(NamedTuple):
    """Mean and deviation of each coordinate; constants, as the data are."""

    mean: Float32[np.ndarray, "n"]
    deviation: Float32[np.ndarray, "n"]  # at least `DEVIATION_FLOOR`

    @classmethod
    def of(cls, observations: Table) -> "Statistics":
        """Statistics of the rows of `observations`, evenly subsampled if there are many."""
        stride = -(-len(observations) // _ROWS)
        rows = np.asarray(observations[::stride], np.float64)
        deviation = np.maximum(rows.std(axis=0), DEVIATION_FLOOR)
        return cls(rows.mean(axis=0).astype(np.float32), deviation.astype(np.float32))

    @classmethod
    def standard(cls, size: int) -> "Statistics":
        """Statistics of `size` coordinates that are already standardised."""
        return cls(np.zeros(size, np.float32), np.ones(size, np.float32))

    def select(self, parts: Mapping[str, slice]) -> "Statistics":
        """Statistics of some terms of an observation, in their order."""
        return Statistics(
            *(np.concatenate([values[part] for part in parts.values()]) for values in self)
        )


def require_statistics(statistics: Statistics | None, what: str) -> Statistics:
    """`statistics`; if there are none, `UserError` saying that `what` needs them."""
    if statistics is None:
        raise UserError(f"{what} needs the statistics of a data set: build the agent with them")
    return statistics
