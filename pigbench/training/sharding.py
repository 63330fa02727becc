"""The distribution of training over several devices: seeds in parallel, batches in parts.

It affects results only by rounding; with one device it does nothing.
"""

from dataclasses import dataclass
from typing import TypeVar

import jax
import numpy as np
from jax.sharding import Mesh, NamedSharding, PartitionSpec

from pigbench.errors import UserError

Tree = TypeVar("Tree")

SEEDS, BATCH = "seeds", "batch"


@dataclass(frozen=True)
class Sharding:
    """Seeds are divided among `seeds` groups of devices, batches among `batch` in each group."""

    seeds: int = 1
    batch: int = 1

    @classmethod
    def over_all(cls, *, seeds: int, batch_size: int, data_parallel: bool) -> "Sharding":
        """Use as many devices as evenly divide the seeds and, if requested, the batches.

        Raises UserError if batches are to be divided and no second device is left for that.
        """
        count = jax.device_count()
        shared = _most(count, seeds)
        parts = _most(count // shared, batch_size) if data_parallel else 1
        if data_parallel and parts == 1:
            raise UserError(
                f"data_parallel shares batches of {batch_size} among devices, and of the {count} "
                "here none is left for that: leave it out"
            )
        return cls(shared, parts)

    @property
    def devices(self) -> int:
        """The number of devices in use."""
        return self.seeds * self.batch

    def __str__(self) -> str:
        return f"on {self.devices} devices" if self.devices > 1 else ""

    def share_state(self, tree: Tree, *, joined: bool) -> Tree:
        """Within a program: distribute leaves whose first axis is over seeds if they are joined."""
        return self._constrain(tree, *_axes(joined))

    def share_batch(self, tree: Tree) -> Tree:
        """Within a program for one seed: distribute leaves whose first axis is over examples."""
        return self._constrain(tree, BATCH)

    def spread(self, tree: Tree, *, joined: bool) -> Tree:
        """Move arrays to the devices in use, as `share_state` leaves them in a program."""
        return tree if self.devices == 1 else jax.device_put(tree, self._named(*_axes(joined)))

    def collect(self, tree: Tree) -> Tree:
        """Move a program's results to the first device, where all else is done."""
        return tree if self.devices == 1 else jax.device_put(tree, jax.devices()[0])

    def _constrain(self, tree: Tree, *axes: str) -> Tree:
        if self.devices == 1:
            return tree
        return jax.lax.with_sharding_constraint(tree, self._named(*axes))

    def _named(self, *axes: str) -> NamedSharding:
        devices = np.array(jax.devices()[: self.devices]).reshape(self.seeds, self.batch)
        return NamedSharding(Mesh(devices, (SEEDS, BATCH)), PartitionSpec(*axes))


def _axes(joined: bool) -> tuple[str, ...]:
    return (SEEDS,) if joined else ()


def _most(devices: int, things: int) -> int:
    """The largest number of devices, up to `devices`, that divides `things` evenly."""
    return max(count for count in range(1, devices + 1) if things % count == 0)
