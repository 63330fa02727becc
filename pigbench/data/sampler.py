"""Batches with relabelled goals, as a pure function of a key.

Drawing indices is separate from gathering rows, so rows may be on the device or on disk.
"""

import jax
import jax.numpy as jnp
import numpy as np
from flax import struct
from jax.typing import ArrayLike
from jaxtyping import Float, Int, Key

from pigbench.agents import Batch, GoalMixture, Sampling, Subgoals, SubgoalSampling, ValueGoals
from pigbench.data.dataset import Split
from pigbench.data.mapped import MappedArray
from pigbench.errors import UserError
from pigbench.shapes import Array

RowNumbers = Int[Array, "*step batch"]


@struct.dataclass
class Rows:
    """A data set's rows; episodes are contiguous, and an episode's last row has no successor.

    The rows of a data set that is too large for the device stay on disk and are gathered there.
    """

    observations: Float[Array, "row observation"] | MappedArray
    actions: Float[Array, "row action"] | MappedArray
    episode_ends: Int[Array, "episode"]  # each episode's last row, ascending

    @classmethod
    def create(cls, observations: ArrayLike, actions: ArrayLike, terminals: ArrayLike) -> "Rows":
        """Rows on the device; `terminals` are true on each episode's last row.

        Raises UserError if the last episode has no end or no row has a successor.
        """
        terminals = np.asarray(terminals, dtype=bool)
        if not terminals[-1:].all():
            raise UserError("the data set's last row is not terminal: its last episode is cut off")
        return cls(
            jnp.asarray(observations),
            jnp.asarray(actions),
            _checked(np.flatnonzero(terminals), rows=len(terminals)),
        )

    @classmethod
    def from_split(cls, split: Split) -> "Rows":
        """All rows of a data set's split, on the device."""
        fields = ("observations", "actions", "terminals")
        return cls.create(*(split.concatenate(field) for field in fields))

    @classmethod
    def on_disk(cls, split: Split) -> "Rows":
        """All rows of a data set's split, on disk; only gathered rows are read."""
        ends = _checked(split.episode_ends, rows=split.rows)
        return cls(split.mapped("observations"), split.mapped("actions"), ends)


def _checked(episode_ends: Int[np.ndarray, "episode"], *, rows: int) -> Int[Array, "episode"]:
    if len(episode_ends) == rows:
        raise UserError("the data set has no transition: an episode needs at least two rows")
    return jnp.asarray(episode_ends, jnp.int32)


@struct.dataclass
class SubgoalIndices:
    """Row numbers of a batch's `Subgoals`."""

    value_subgoals: RowNumbers
    actor_subgoals: RowNumbers
    low_actor_goals: RowNumbers
    low_value_goals: RowNumbers | None


@struct.dataclass
class Indices:
    """Row numbers of a batch; a transition leads from `starts` to the next row."""

    starts: RowNumbers
    actor_goals: RowNumbers
    value_goals: RowNumbers | None
    subgoals: SubgoalIndices | None


def sample(key: Key[Array, ""], rows: Rows, sampling: Sampling, batch_size: int) -> Batch:
    """A batch of `batch_size` transitions, uniform over all, with goals drawn by `sampling`."""
    return gather(rows, sample_indices(key, rows.episode_ends, sampling, batch_size))


def gather(rows: Rows, indices: Indices) -> Batch:
    """The batch described by `indices`, with their axes; in NumPy for rows on disk."""
    starts, subgoals = indices.starts, indices.subgoals
    numbers, structure = jax.tree.flatten((indices, starts + 1))
    stack = starts.__array_namespace__().stack  # NumPy's or JAX's, as the indices are
    # All at once, so that a file of rows on disk is visited only once.
    found = rows.observations[stack(numbers)]
    states, next_observations = jax.tree.unflatten(structure, list(found))
    return Batch(
        observations=states.starts,
        actions=rows.actions[starts],
        next_observations=next_observations,
        actor_goals=states.actor_goals,
        for_value=_for_value(states.value_goals, indices.value_goals, starts),
        subgoals=Subgoals(
            value_subgoals=states.subgoals.value_subgoals,
            value_steps=subgoals.value_subgoals - starts,
            value_success=_same(subgoals.value_subgoals, indices.value_goals),
            actor_subgoals=states.subgoals.actor_subgoals,
            low_actor_goals=states.subgoals.low_actor_goals,
            low_for_value=_for_value(
                states.subgoals.low_value_goals, subgoals.low_value_goals, starts
            ),
        )
        if subgoals
        else None,
    )


def _for_value(
    goals: Float[Array, "*step batch observation"] | None,
    rows: RowNumbers | None,
    starts: RowNumbers,
) -> ValueGoals | None:
    return None if goals is None else ValueGoals(goals, success=_same(rows, starts))


def _same(rows: RowNumbers | None, others: RowNumbers | None) -> Float[Array, "*step batch"]:
    return (rows == others).astype(jnp.float32)


def sample_indices(
    key: Key[Array, ""], episode_ends: Int[Array, "episode"], sampling: Sampling, batch_size: int
) -> Indices:
    """Transitions, uniform over all, with a goal from each mixture; `episode_ends` as in `Rows`."""
    start_key, value_key, actor_key, low_key = jax.random.split(key, 4)
    # Transitions up to and including each episode: one row per episode starts none.
    transitions = episode_ends - jnp.arange(len(episode_ends), dtype=jnp.int32)
    draws = jax.random.randint(start_key, (batch_size,), 0, transitions[-1])
    episodes = jnp.searchsorted(transitions, draws, side="right").astype(jnp.int32)
    starts = draws + episodes
    ends = episode_ends[episodes]

    def goals(key: Key[Array, ""], mixture: GoalMixture, discount: float) -> Int[Array, "batch"]:
        source_key, future_key, random_key = jax.random.split(key, 3)
        if mixture.geometric:
            future = _geometric_future(future_key, starts, ends, discount)
        else:
            future = jax.random.randint(future_key, starts.shape, starts + 1, ends + 1)
        random = jax.random.randint(random_key, starts.shape, 0, episode_ends[-1] + 1)
        source = jax.random.uniform(source_key, starts.shape)
        return jnp.where(
            source < mixture.current,
            starts,
            jnp.where(source < 1 - mixture.random, future, random),
        )

    def subgoals(sampling: SubgoalSampling) -> SubgoalIndices:
        assert value_goals is not None  # as `Sampling` makes sure
        ahead = jnp.minimum(starts + sampling.steps, ends)
        low = sampling.low_value_goals
        return SubgoalIndices(
            value_subgoals=_no_further(ahead, starts, value_goals),
            actor_subgoals=_no_further(ahead, starts, actor_goals),
            low_actor_goals=ahead,
            low_value_goals=low and goals(low_key, low, sampling.low_discount),
        )

    mixture = sampling.value_goals
    value_goals = mixture and goals(value_key, mixture, sampling.discount)
    actor_goals = goals(actor_key, sampling.actor_goals, sampling.discount)
    return Indices(
        starts,
        actor_goals,
        value_goals,
        subgoals(sampling.subgoals) if sampling.subgoals else None,
    )


def _geometric_future(
    key: Key[Array, ""], starts: Int[Array, "batch"], ends: Int[Array, "batch"], discount: float
) -> Int[Array, "batch"]:
    """`starts` plus k = 1, 2, ... with probability (1 - discount) discount^(k - 1), clipped."""
    steps = jax.random.geometric(key, 1 - discount, starts.shape, dtype=jnp.int32)
    return jnp.minimum(starts + steps, ends)


def _no_further(
    ahead: Int[Array, "batch"], starts: Int[Array, "batch"], goals: Int[Array, "batch"]
) -> Int[Array, "batch"]:
    """`ahead`, or the goal where it is between `starts` and `ahead`."""
    return jnp.where((starts <= goals) & (goals <= ahead), goals, ahead)
