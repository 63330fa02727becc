"""Sources of batches for updates: drawn by the compiled program itself, or gathered by threads.

Either way, update t of a seed gets what `sampler.sample` draws from `keys_of(key, t)`.
"""

import contextlib
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, Protocol

import jax
import numpy as np
from jaxtyping import Array, Int, Key

from pigbench.agents import Agent, Batch
from pigbench.data import sampler
from pigbench.data.mapped import MappedArray
from pigbench.data.sampler import Indices, Rows
from pigbench.support import cores

StepNumber = Int[Array, ""] | int

_BLOCK = 16e6  # approximate bytes that threads gather at a time
_MOST_UPDATES = 256  # per block: training starts only when the first block is complete
_AHEAD = 4  # blocks gathered or being gathered beyond the one in use


class Batches(Protocol):
    """The batches of a training run; updates run in parts, each one call of a compiled program."""

    axis: int | None
    """The axis of a part's arrays over the seeds trained together; None if there is none."""

    def parts(self, start: int, stop: int) -> Iterator[tuple[Any, int]]:
        """Yield the inputs of `batch` for updates from `start` up to `stop`, with their ends."""
        ...

    def batch(self, part: Any, key: Key[Array, ""], step: StepNumber) -> Batch:
        """The batch of a seed's update `step`, drawn with `key`. Pure."""
        ...


def keys_of(key: Key[Array, ""], step: StepNumber) -> tuple[Key[Array, ""], Key[Array, ""]]:
    """The keys of the batch and of the update itself, given a seed's key and the update's step."""
    batch_key, update_key = jax.random.split(jax.random.fold_in(key, step))
    return batch_key, update_key


@contextlib.contextmanager
def of(rows: Rows, agent: Agent, key: Key[Array, "*seed"]) -> Iterator[Batches]:
    """The batches that `agent` needs from `rows`, given the key of a seed or of several."""
    if not isinstance(rows.observations, MappedArray):
        yield Drawn(rows, agent)
        return
    gathered = Gathered(rows, agent, key)
    try:
        yield gathered
    finally:
        gathered.close()


class Drawn:
    """Batches from rows on the device: all updates are one part."""

    axis: int | None = None

    def __init__(self, rows: Rows, agent: Agent) -> None:
        self._rows, self._agent = rows, agent

    def parts(self, start: int, stop: int) -> Iterator[tuple[Rows, int]]:
        """Yield the rows, with which any number of updates can run."""
        del start
        yield self._rows, stop

    def batch(self, part: Rows, key: Key[Array, ""], step: StepNumber) -> Batch:
        """Draw the batch within the program."""
        del step
        return sampler.sample(key, part, self._agent.sampling, self._agent.config.batch_size)


class Gathered:
    """Batches from rows on disk: a part is a block of batches, gathered in threads that run ahead.

    Block b has the batches of the n updates from step b n on, whatever the step at which training
    starts.
    """

    axis: int | None = 0

    def __init__(self, rows: Rows, agent: Agent, key: Key[Array, "*seed"]) -> None:
        self._rows, self._key = rows, key
        sampling, size = agent.sampling, agent.config.batch_size

        def draw(key: Key[Array, ""], steps: Int[Array, "step"]) -> Indices:
            def one(step: Int[Array, ""]) -> Indices:
                batch_key, _ = keys_of(key, step)
                return sampler.sample_indices(batch_key, rows.episode_ends, sampling, size)

            return jax.vmap(one)(steps)

        draw_all = jax.vmap(draw, in_axes=(0, None)) if key.ndim else draw
        indices = jax.eval_shape(draw_all, key, np.zeros(1, np.int32))
        # The states after the starts are gathered too, whose numbers are not among the indices.
        states = sum(leaf.size for leaf in jax.tree.leaves(indices)) + indices.starts.size
        bytes_a_state = rows.observations.shape[-1] * rows.observations.dtype.itemsize
        self._updates = max(1, min(_MOST_UPDATES, int(_BLOCK // (states * bytes_a_state))))
        # Compiled before the threads use it, since otherwise each of them would compile it.
        self._draw = jax.jit(draw_all).lower(key, self._steps(0)).compile()
        self._blocks: dict[int, Future[Batch]] = {}
        self._threads = ThreadPoolExecutor(min(_AHEAD, cores.available()), "gather")

    def parts(self, start: int, stop: int) -> Iterator[tuple[Batch, int]]:
        """Yield parts that end where their blocks do."""
        while start < stop:
            number = start // self._updates
            end = min(stop, (number + 1) * self._updates)
            yield self._block(number), end
            start = end

    def batch(self, part: Batch, key: Key[Array, ""], step: StepNumber) -> Batch:
        """Take the batch out of its block."""
        del key
        place = step % self._updates
        return jax.tree.map(lambda x: jax.lax.dynamic_index_in_dim(x, place, keepdims=False), part)

    def close(self) -> None:
        """Stop gathering."""
        self._threads.shutdown(cancel_futures=True)

    def _block(self, number: int) -> Batch:
        self._blocks = {
            block: self._blocks.get(block) or self._threads.submit(self._gather, block)
            for block in range(number, number + _AHEAD + 1)
        }
        return self._blocks[number].result()

    def _gather(self, number: int) -> Batch:
        indices = jax.device_get(self._draw(self._key, self._steps(number)))
        return jax.device_put(sampler.gather(self._rows, indices))

    def _steps(self, number: int) -> Int[np.ndarray, "step"]:
        first = number * self._updates
        return np.arange(first, first + self._updates, dtype=np.int32)
