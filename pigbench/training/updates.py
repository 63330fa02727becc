"""Updates in a compiled loop, of one seed or of several together.

The states of seeds trained together are joined: each leaf has a first axis over the seeds. They
stay so, on the devices in use, from one call to the next.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Int, Key, Shaped

from pigbench import agents
from pigbench.agents import Agent, Batch, Metrics, TrainState
from pigbench.training import batches
from pigbench.training.batches import Batches, StepNumber
from pigbench.training.sharding import SEEDS, Sharding

Tree = TypeVar("Tree")

ONE_DEVICE = Sharding()

MeanMetrics = dict[str, np.float32]

Updates = Callable[[TrainState, int, int], tuple[TrainState, list[MeanMetrics]]]
"""Updates a joined state from one step up to another; returns the new one and mean metrics by seed.

The given state cannot be used afterwards.
"""


def make_updates(
    agent: Agent, key: Key[Array, "*seed"], source: Batches, sharding: Sharding = ONE_DEVICE
) -> Updates:
    """The updates of the seed with `key`, or of several seeds together.

    Update t of a seed draws its batch and everything else from `fold_in(key, t)` alone.
    """
    loop = partial(_loop, agent, source, sharding)
    if key.ndim:
        loop = jax.vmap(loop, in_axes=(0, 0, source.axis, None, None), spmd_axis_name=SEEDS)

    @partial(jax.jit, donate_argnums=0)
    def run(
        state: TrainState, key: Key[Array, "*seed"], part: Any, start: int, stop: int
    ) -> tuple[TrainState, dict[str, Shaped[Array, "*seed"]]]:
        state, sums = loop(state, key, part, start, stop)
        return sharding.share_state(state, joined=bool(key.ndim)), sums

    def updates(state: TrainState, start: int, stop: int) -> tuple[TrainState, list[MeanMetrics]]:
        sums, done = [], start
        state = sharding.spread(state, joined=bool(key.ndim))
        for part, end in source.parts(start, stop):
            state, part_sums = run(state, key, part, done, end)
            jax.block_until_ready(sums[-1:])  # so that at most two parts are on the device
            sums.append(part_sums)
            done = end
        means = jax.tree.map(lambda *x: sum(x) / (stop - start), *jax.device_get(sums))
        return state, split(means, key.size)

    return updates


def _loop(
    agent: Agent,
    source: Batches,
    sharding: Sharding,
    state: TrainState,
    key: Key[Array, ""],
    part: Any,
    start: int,
    stop: int,
) -> tuple[TrainState, Metrics]:
    """Do the updates of a part, of one seed; also returns the sums of their metrics."""

    def batch(step: StepNumber) -> Batch:
        batch_key, _ = batches.keys_of(key, step)
        return sharding.share_batch(source.batch(part, batch_key, step))

    def update(step: StepNumber, state: TrainState, batch: Batch):
        _, update_key = batches.keys_of(key, step)
        return agents.update(agent, state, batch, update_key)

    def body(step: Int[Array, ""], carry: tuple[TrainState, Batch, Metrics]):
        state, now, sums = carry
        state, metrics = update(step, state, now)
        return state, batch(step + 1), jax.tree.map(jnp.add, sums, metrics)

    # Each iteration is passed its batch, so that an update is compiled independently of the
    # batch's source and gives the same numbers for every source.
    first = batch(start)
    _, metrics = jax.eval_shape(update, start, state, first)
    sums = jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), metrics)
    state, _, sums = jax.lax.fori_loop(start, stop, body, (state, first, sums))
    return state, sums


def join(trees: Sequence[Tree]) -> Tree:
    """Stack the trees of several seeds; the tree of a single seed is returned as it is."""
    return _stacked(tuple(trees)) if len(trees) > 1 else trees[0]


def split(tree: Tree, seeds: int) -> list[Tree]:
    """The inverse of `join`."""
    return _split(tree, seeds) if seeds > 1 else [tree]


# Compiled, because every leaf of every tree would be a separate call otherwise.
@jax.jit
def _stacked(trees: tuple[Tree, ...]) -> Tree:
    return jax.tree.map(lambda *x: jnp.stack(x), *trees)


@partial(jax.jit, static_argnums=1)
def _split(tree: Tree, seeds: int) -> list[Tree]:
    return [jax.tree.map(lambda leaf: leaf[number], tree) for number in range(seeds)]  # noqa: B023
