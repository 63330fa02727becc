"""Where a data set's rows are during training: on the device, or still on disk."""

from collections.abc import Callable
from typing import NamedTuple

import jax

from pigbench.data import shard
from pigbench.data.dataset import Split
from pigbench.data.defaults import HomeChoice
from pigbench.data.sampler import Rows
from pigbench.support import memory

_HOMES: dict[str, Callable[[Split], Rows]] = {"device": Rows.from_split, "disk": Rows.on_disk}
_GB = 1e9


class Home(NamedTuple):
    """A choice and the reason for it."""

    name: str
    reason: str

    def __str__(self) -> str:
        return f"rows on {self.name} ({self.reason})"


def choose(asked: HomeChoice, split: Split) -> Home:
    """The home that was asked for, or the one that suits the split's size."""
    if asked != "auto":
        return Home(asked, "as asked")
    need, room = size(split), _room()
    fits = need <= room
    return Home(
        "device" if fits else "disk",
        f"{need / _GB:.1f} GB, room for {room / _GB:.1f}",
    )


def open_rows(split: Split, home: Home) -> Rows:
    """Open all rows of a split in their home."""
    return _HOMES[home.name](split)


def size(split: Split) -> int:
    """Bytes that a split's rows take in memory."""
    numbers = split.spec.layout.size + split.spec.action_size
    return split.rows * numbers * shard.DTYPES["observations"].itemsize


def _room() -> int:
    """Bytes that rows may take: half of a device's memory, a quarter of our share of a host's."""
    statistics = jax.devices()[0].memory_stats()
    if statistics is not None and "bytes_limit" in statistics:
        return statistics["bytes_limit"] // 2
    # Rows are in memory twice while they are read.
    return memory.share() // 4
