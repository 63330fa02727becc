"""Where a data set's rows live while methods train on it: on the device, or still on the disk."""

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
    """A choice, and why it was made."""

    name: str
    reason: str

    def __str__(self) -> str:
        return f"rows on {self.name} ({self.reason})"


def choose(asked: HomeChoice, split: Split) -> Home:
    """The home that is asked for, or that the size of a split suggests."""
    if asked != "auto":
        return Home(asked, "as asked")
    need, room = size(split), _room()
    fits = need <= room
    return Home(
        "device" if fits else "disk",
        f"{need / _GB:.1f} GB, room for {room / _GB:.1f}",
    )


def open_rows(split: Split, home: Home) -> Rows:
    """All rows of a split, in their home."""
    return _HOMES[home.name](split)


def size(split: Split) -> int:
    """Bytes of a split's rows in memory."""
    numbers = split.spec.observation_size + split.spec.action_size
    return split.rows * numbers * shard.DTYPES["observations"].itemsize


def _room() -> int:
    """Bytes that rows may take: half of the device's memory, of a host's a quarter."""
    statistics = jax.devices()[0].memory_stats()
    if statistics is not None and "bytes_limit" in statistics:
        return statistics["bytes_limit"] // 2
    # They are there twice while they are read.
    return memory.physical() // 4
