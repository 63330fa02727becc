"""How a training lies on several devices: seeds side by side, a batch in parts.

What the numbers are does not depend on it but for rounding; one device is as if none of this were.
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
class Layout:
    """So many devices share the seeds, and for each of their shares so many a batch."""

    seeds: int = 1
    batch: int = 1

    @classmethod
    def over_all(cls, *, seeds: int, batch_size: int, data_parallel: bool) -> "Layout":
        """Over as many devices as divide the seeds and, if asked for, the batches.

        Raises UserError if batches are to be shared and there is no second device to do so.
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
        """All of them."""
        return self.seeds * self.batch

    def __str__(self) -> str:
        return f"on {self.devices} devices" if self.devices > 1 else ""

    def share_seeds(self, tree: Tree) -> Tree:
        """Within a program: leaves whose first axis counts seeds, laid over the devices."""
        return self._constrain(tree, SEEDS)

    def share_batch(self, tree: Tree) -> Tree:
        """Within a program, of one seed: leaves whose first axis counts examples."""
        return self._constrain(tree, BATCH)

    def spread(self, tree: Tree) -> Tree:
        """Arrays copied to all devices, for a program that runs on them."""
        return tree if self.devices == 1 else jax.device_put(tree, self._sharding())

    def collect(self, tree: Tree) -> Tree:
        """A program's results on the first device alone, where the rest is done."""
        return tree if self.devices == 1 else jax.device_put(tree, jax.devices()[0])

    def _constrain(self, tree: Tree, axis: str) -> Tree:
        if self.devices == 1:
            return tree
        return jax.lax.with_sharding_constraint(tree, self._sharding(axis))

    def _sharding(self, *axes: str) -> NamedSharding:
        devices = np.array(jax.devices()[: self.devices]).reshape(self.seeds, self.batch)
        return NamedSharding(Mesh(devices, (SEEDS, BATCH)), PartitionSpec(*axes))


def _most(devices: int, things: int) -> int:
    """As many of the devices as share so many things evenly."""
    return max(count for count in range(1, devices + 1) if things % count == 0)
