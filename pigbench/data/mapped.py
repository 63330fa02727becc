"""A field of many shards as one array that stays on disk."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pigbench.data.shard import FieldArray
from pigbench.errors import UserError


class MappedArray:
    """The rows of several arrays, one array after another, gathered on demand.

    `paths` are the arrays' files. Threads may share an instance: gathering takes no lock.
    """

    def __init__(self, arrays: Sequence[FieldArray], paths: Sequence[Path]) -> None:
        self._arrays = [np.asarray(array) for array in arrays]  # `take` is slow on a `memmap`
        self._paths = paths
        self._starts = np.cumsum([0, *map(len, self._arrays)])

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of all arrays together."""
        return int(self._starts[-1]), *self._arrays[0].shape[1:]

    @property
    def dtype(self) -> np.dtype[Any]:
        """The type of every array."""
        return self._arrays[0].dtype

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, rows: Any) -> Any:
        """The rows with the given numbers, or of a slice, in memory: (...) to (..., *shape[1:]).

        Raises UserError, naming the file, if one of them contains NaN or infinity.
        """
        if isinstance(rows, slice):
            rows = np.arange(*rows.indices(len(self)))
        wanted = np.ravel(rows)
        owners = np.searchsorted(self._starts, wanted, side="right") - 1
        # Array by array; within each in the given order, which is no slower than ascending.
        small = owners.astype(np.min_scalar_type(len(self._arrays)))  # 16 bits: radix sort
        order = np.argsort(small, kind="stable")
        bounds = np.searchsorted(owners[order], np.arange(len(self._arrays) + 1))
        found = np.empty((len(wanted), *self.shape[1:]), self.dtype)
        for number in np.flatnonzero(np.diff(bounds)):
            places = order[bounds[number] : bounds[number + 1]]
            found[places] = self._arrays[number].take(wanted[places] - self._starts[number], axis=0)
        if not np.isfinite(found).all():
            bad = int(np.argmin(np.isfinite(found).all(axis=tuple(range(1, found.ndim)))))
            owner = owners[bad]
            raise UserError(
                f"{self._paths[owner]} holds NaN or infinity (in row "
                f"{wanted[bad] - self._starts[owner]}); look for more with `pigbench data verify`"
            )
        return found.reshape(*np.shape(rows), *self.shape[1:])
