import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats

from pigbench.agents import GoalMixture, Sampling, SubgoalSampling
from pigbench.data.sampler import Rows, sample, sample_indices
from pigbench.errors import UserError

LENGTHS = (7, 1, 2, 30, 1, 10)
"""Rows of each episode; an episode of one row has no transition."""

DRAWS = 50_000
SIGNIFICANCE = 1e-3

CURRENT = GoalMixture(current=1.0, future=0.0, random=0.0, geometric=False)
UNIFORM = GoalMixture(current=0.0, future=1.0, random=0.0, geometric=False)
GEOMETRIC = GoalMixture(current=0.0, future=1.0, random=0.0, geometric=True)
RANDOM = GoalMixture(current=0.0, future=0.0, random=1.0, geometric=False)
MIXED = GoalMixture(current=0.2, future=0.5, random=0.3, geometric=True)


def draw(value_goals, actor_goals=UNIFORM, *, lengths=LENGTHS, discount=0.8, size=DRAWS):
    ends = jnp.asarray(np.cumsum(lengths) - 1, dtype=jnp.int32)
    indices = sample_indices(
        jax.random.key(0), ends, Sampling(value_goals, actor_goals, discount), size
    )
    return (
        np.asarray(indices.starts),
        np.asarray(indices.value_goals),
        np.asarray(indices.actor_goals),
    )


def last_rows(starts):
    return np.repeat(np.cumsum(LENGTHS) - 1, LENGTHS)[starts]


def test_starts_are_uniform_over_the_rows_with_a_successor():
    starts, _, _ = draw(CURRENT)
    has_successor = last_rows(np.arange(sum(LENGTHS))) != np.arange(sum(LENGTHS))
    counts = np.bincount(starts, minlength=sum(LENGTHS))
    assert not counts[~has_successor].any()
    assert stats.chisquare(counts[has_successor]).pvalue > SIGNIFICANCE


def test_current_goals_are_the_start():
    starts, goals, _ = draw(CURRENT)
    np.testing.assert_array_equal(goals, starts)


def test_random_goals_are_uniform_over_all_rows():
    starts, goals, _ = draw(RANDOM)
    assert stats.chisquare(np.bincount(goals, minlength=sum(LENGTHS))).pvalue > SIGNIFICANCE
    assert stats.chi2_contingency(np.histogram2d(starts, goals, bins=4)[0]).pvalue > SIGNIFICANCE


@pytest.mark.parametrize("mixture", [UNIFORM, GEOMETRIC])
def test_future_goals_lie_ahead_in_the_same_episode(mixture):
    starts, goals, _ = draw(mixture)
    assert np.all(goals > starts)
    assert np.all(goals <= last_rows(starts))


def test_uniform_future_goals_are_uniform_over_the_rest_of_the_episode():
    starts, goals, _ = draw(UNIFORM, lengths=(9,))
    for start in range(7):
        counts = np.bincount(goals[starts == start], minlength=9)
        assert stats.chisquare(counts[start + 1 :]).pvalue > SIGNIFICANCE


def test_geometric_future_goals_follow_the_discount_and_end_with_the_episode():
    starts, goals, _ = draw(GEOMETRIC, lengths=(31, 31))
    left = 30 - starts % 31
    for remaining in (2, 5, 10):
        steps = (goals - starts)[left == remaining]
        law = [0.2 * 0.8 ** (k - 1) for k in range(1, remaining)] + [0.8 ** (remaining - 1)]
        counts = np.bincount(steps, minlength=remaining + 1)[1:]
        assert stats.chisquare(counts, len(steps) * np.array(law)).pvalue > SIGNIFICANCE


def test_mixtures_keep_their_shares():
    """In one long episode, current, future and random goals are told apart by where they fall."""
    length = 2_000_000
    starts, goals, actor_goals = draw(MIXED, GEOMETRIC, lengths=(length,))
    near = (goals > starts) & (goals <= starts + 200)
    for hits, share in (((goals == starts).sum(), 0.2), (near.sum(), 0.5)):
        assert stats.binomtest(int(hits), DRAWS, share).pvalue > SIGNIFICANCE
    assert np.all(actor_goals > starts)


def test_success_is_the_start_being_the_goal_and_rows_are_gathered():
    """Every observation is its own row number, and an action ten times that."""
    numbers = np.arange(sum(LENGTHS), dtype=np.float32)
    terminals = np.isin(numbers, np.cumsum(LENGTHS) - 1)
    rows = Rows.create(numbers[:, None], 10 * numbers[:, None], terminals)
    batch = sample(jax.random.key(0), rows, Sampling(MIXED, UNIFORM, 0.8), 4000)

    observations = np.asarray(batch.observations[:, 0])
    np.testing.assert_array_equal(batch.actions[:, 0], 10 * observations)
    np.testing.assert_array_equal(batch.next_observations[:, 0], observations + 1)
    np.testing.assert_array_equal(batch.value_success, batch.value_goals[:, 0] == observations)
    assert batch.value_success.dtype == jnp.float32
    assert 0 < batch.value_success.mean() < 1
    assert np.all(batch.actor_goals[:, 0] > observations)


@pytest.mark.parametrize("steps", [1, 4])
def test_subgoals_lie_steps_ahead_or_at_the_goal_or_at_the_end(steps):
    """Every observation is its own row number, so each transition is followed by hand."""
    numbers = np.arange(sum(LENGTHS), dtype=np.float32)
    terminals = np.isin(numbers, np.cumsum(LENGTHS) - 1)
    rows = Rows.create(numbers[:, None], numbers[:, None], terminals)
    sampling = Sampling(
        MIXED, UNIFORM, 0.8, SubgoalSampling(steps, low_value_goals=MIXED, low_discount=0.5)
    )
    batch = sample(jax.random.key(0), rows, sampling, 4000)
    subgoals = batch.subgoals
    starts, value_goals, actor_goals, ahead = (
        np.asarray(column[:, 0], int)
        for column in (
            batch.observations,
            batch.value_goals,
            batch.actor_goals,
            subgoals.low_actor_goals,
        )
    )
    np.testing.assert_array_equal(ahead, np.minimum(starts + steps, last_rows(starts)))

    def stops(goals):
        return [
            goal if goal in range(start, last + 1) else last
            for start, last, goal in zip(starts, ahead, goals, strict=True)
        ]

    value_stops = np.array(stops(value_goals))
    np.testing.assert_array_equal(subgoals.value_subgoals[:, 0], value_stops)
    np.testing.assert_array_equal(subgoals.value_steps, value_stops - starts)
    np.testing.assert_array_equal(subgoals.value_success, value_stops == value_goals)
    np.testing.assert_array_equal(subgoals.actor_subgoals[:, 0], stops(actor_goals))
    np.testing.assert_array_equal(
        subgoals.low_for_value.success, subgoals.low_for_value.states[:, 0] == starts
    )
    # All cases were met: at the goal already, at it after some steps, and not there.
    met = set(zip(np.asarray(subgoals.value_steps), value_stops == value_goals, strict=True))
    assert {(0, True), (steps, True), (steps, False)} <= met


def test_the_low_levels_goals_follow_its_own_mixture_and_discount():
    sampling = Sampling(
        RANDOM, UNIFORM, 0.8, SubgoalSampling(5, low_value_goals=GEOMETRIC, low_discount=0.5)
    )
    ends = jnp.array([30], jnp.int32)
    indices = sample_indices(jax.random.key(0), ends, sampling, DRAWS)
    starts, goals = (
        np.asarray(column) for column in (indices.starts, indices.subgoals.low_value_goals)
    )
    steps = (goals - starts)[starts < 15]
    counts = np.bincount(np.minimum(steps, 6), minlength=7)[1:]
    law = [0.5, 0.25, 0.125, 0.0625, 0.03125, 0.03125]
    assert stats.chisquare(counts, len(steps) * np.array(law)).pvalue > SIGNIFICANCE


def test_goals_that_are_not_asked_for_are_not_drawn_and_leave_the_other_draws_alone():
    ends = jnp.asarray(np.cumsum(LENGTHS) - 1, dtype=jnp.int32)
    whole, value_alone, plain = (
        sample_indices(jax.random.key(0), ends, Sampling(goals, UNIFORM, 0.8, subgoals), 100)
        for goals, subgoals in (
            (MIXED, SubgoalSampling(5, low_value_goals=MIXED, low_discount=0.5)),
            (MIXED, SubgoalSampling(5, low_value_goals=None, low_discount=0.5)),
            (None, None),
        )
    )
    assert value_alone.subgoals.low_value_goals is None
    assert (plain.value_goals, plain.subgoals) == (None, None)
    wanted = dict(jax.tree_util.tree_flatten_with_path(whole)[0])
    for indices in (value_alone, plain):
        for place, numbers in jax.tree_util.tree_flatten_with_path(indices)[0]:
            np.testing.assert_array_equal(numbers, wanted[place])


def test_a_batch_has_no_more_than_was_drawn():
    rows = Rows.create(np.zeros((5, 1)), np.zeros((5, 1)), np.arange(5) == 4)
    plain = sample(jax.random.key(0), rows, Sampling(None, UNIFORM, 0.8), 10)
    assert (plain.for_value, plain.subgoals) == (None, None)
    of_low = SubgoalSampling(2, low_value_goals=None, low_discount=0.5)
    batch = sample(jax.random.key(0), rows, Sampling(MIXED, UNIFORM, 0.8, of_low), 10)
    assert batch.subgoals.low_for_value is None


def test_a_hundred_million_rows():
    """Rows beyond 2^24, where float32 skips integers, are all reached: odd as often as even."""
    episodes, length = 100_000, 1001
    starts, goals, _ = draw(RANDOM, lengths=(length,) * episodes)
    assert starts.max() > 0.999 * episodes * length
    for rows in (starts, goals):
        assert stats.binomtest(int((rows % 2).sum()), DRAWS).pvalue > SIGNIFICANCE
        uniform = stats.uniform(0, episodes * length)
        assert stats.kstest(rows, uniform.cdf).pvalue > SIGNIFICANCE
    assert np.all(starts % length != length - 1)


def test_a_batch_is_a_pure_function_of_its_key():
    ends = jnp.asarray(np.cumsum(LENGTHS) - 1, dtype=jnp.int32)
    sampling = Sampling(MIXED, UNIFORM, 0.8)
    keys = jax.random.split(jax.random.key(1), 4)

    def draw_one(key):
        return sample_indices(key, ends, sampling, 16)

    singly = jax.tree.map(lambda *rows: jnp.stack(rows), *[draw_one(key) for key in keys])
    scanned = jax.lax.scan(lambda _, key: (None, draw_one(key)), None, keys)[1]
    for other in (jax.jit(jax.vmap(draw_one))(keys), scanned):
        assert jax.tree.all(jax.tree.map(lambda a, b: (a == b).all(), singly, other))
    assert len({leaf.tobytes() for leaf in np.asarray(singly.starts)}) == len(keys)


@pytest.mark.parametrize(
    ("terminals", "message"),
    [
        ([], "no transition"),
        ([True, True], "no transition"),
        ([True, False], "last row is not terminal"),
        ([False, False], "last row is not terminal"),
    ],
)
def test_rows_without_a_transition_or_an_end_are_refused(terminals, message):
    states = np.zeros((len(terminals), 1), np.float32)
    with pytest.raises(UserError, match=message):
        Rows.create(states, states, np.array(terminals, dtype=bool))
