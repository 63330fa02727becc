import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench.agents.quasimetrics import IQE, MRN, QUASIMETRICS, interval_lengths


def covered_length(starts, ends):
    """Between neighbouring end points a stretch is covered by an interval or it is not."""
    points = np.sort(np.concatenate([starts, ends]))
    middles = (points[1:] + points[:-1]) / 2
    covered = ((starts[:, None] < middles) & (middles < ends[:, None])).any(axis=0)
    return np.sum(np.diff(points)[covered])


def adversarial_points():
    """Ties, jumps of scale, opposite orders and single coordinates, in 16 dimensions."""
    rng = np.random.default_rng(1)
    steps = np.arange(16.0)
    corners = rng.integers(0, 3, size=(24, 16)).astype(float)
    named = [np.zeros(16), np.ones(16), steps, steps[::-1], 1e4 * steps, 1e-4 * steps, -steps]
    return np.concatenate([corners, named, np.eye(16)[:4], -np.eye(16)[:4]])


@pytest.fixture(params=["random", "adversarial"])
def points(request):
    random = np.random.default_rng(0).normal(size=(40, 16))
    return {"random": random, "adversarial": adversarial_points()}[request.param]


@pytest.fixture(params=QUASIMETRICS)
def distance(request, float64):
    """All distances between embeddings (N, 16): (N, N)."""
    network = QUASIMETRICS[request.param]((8,), 16, layer_norm=True)
    params = network.init(jax.random.key(0), observations=jnp.ones((1, 3)), goals=jnp.ones((1, 3)))
    params = jax.tree.map(lambda leaf: leaf.astype(jnp.float64), params)

    def distance(points):
        inputs = {"starts": points[:, None], "ends": points[None]}
        return np.asarray(network.apply(params, **inputs, method="distance"))

    return distance


def test_covered_lengths_by_hand():
    starts = jnp.array([[0.0, 1.0, 5.0], [0.0, 0.0, 0.0], [0.0, 2.0, 1.0], [3.0, 3.0, 9.0]])
    ends = jnp.array([[2.0, 3.0, 6.0], [1.0, 1.0, 2.0], [1.0, 3.0, 2.0], [1.0, 3.0, 4.0]])
    np.testing.assert_array_equal(interval_lengths(starts, ends), [4.0, 2.0, 3.0, 0.0])


def test_covered_lengths_against_a_sweep(float64):
    rng = np.random.default_rng(0)
    starts, ends = rng.integers(0, 12, size=(2, 200, 5)) + rng.choice([0, 0.5], size=(2, 200, 5))
    expected = [covered_length(x, np.maximum(x, y)) for x, y in zip(starts, ends, strict=True)]
    np.testing.assert_allclose(interval_lengths(starts, ends), expected, atol=1e-12)


def test_gradient_of_covered_lengths(float64):
    """[0, 2] and [1, 3] cover [0, 3]; [5, 6] stands alone; [8, 7] is empty."""
    starts, ends = jnp.array([0.0, 1.0, 5.0, 8.0]), jnp.array([2.0, 3.0, 6.0, 7.0])
    by_start, by_end = jax.grad(interval_lengths, argnums=(0, 1))(starts, ends)
    np.testing.assert_array_equal(by_start, [-1.0, 0.0, -1.0, 0.0])
    np.testing.assert_array_equal(by_end, [0.0, 1.0, 1.0, 0.0])


def test_triangles(distance, points):
    d = distance(points)
    detours = (d[:, :, None] + d[None]).min(axis=1)
    assert np.all(d <= detours + 1e-12 * np.abs(points).max())


def test_no_distance_is_negative_and_none_leads_to_oneself(distance, points):
    d = distance(points)
    assert np.all(d >= -1e-12 * np.abs(points).max())
    np.testing.assert_array_equal(np.diag(d), 0)


def test_the_way_back_may_be_longer(distance, points):
    d = distance(points)
    assert np.mean(np.abs(d - d.T) > 0.1) > 0.5


def test_iqe_by_hand(float64):
    """Components of 2: lengths 3 and 1; a mixture of logit 0 is halfway from 3 to their mean."""
    network = IQE((8,), 4, layer_norm=True, component_size=2)
    starts, ends = jnp.array([0.0, 1.0, 0.0, 5.0]), jnp.array([2.0, 3.0, 1.0, 4.0])

    def distance(logit):
        params = {"params": {"mixture": jnp.array(logit)}}
        return network.apply(params, starts=starts, ends=ends, method="distance")

    np.testing.assert_allclose([distance(0.0), distance(np.log(3))], [2.5, 2.25])


def test_mrn_by_hand():
    """The first half is 5 apart by Pythagoras; the other falls by 2 at most, or by 0 in return."""
    network = MRN((8,), 4, layer_norm=True)
    x, y = jnp.array([0.0, 0.0, 2.0, 1.0]), jnp.array([3.0, 4.0, 0.0, 1.0])
    assert network.apply({}, starts=x, ends=y, method="distance") == 7
    assert network.apply({}, starts=y, ends=x, method="distance") == 5


@pytest.mark.parametrize("kind", QUASIMETRICS)
def test_embeddings_may_be_as_short_as_the_quasimetric_says(kind):
    network = QUASIMETRICS[kind]((8,), QUASIMETRICS[kind].divisor, layer_norm=True)
    states = jax.random.normal(jax.random.key(0), (5, 3))
    distances, _ = network.init_with_output(
        jax.random.key(1), observations=states, goals=states[::-1]
    )
    assert distances.shape == (5,)


@pytest.mark.parametrize("kind", QUASIMETRICS)
def test_gradients_are_finite_where_states_coincide(kind):
    network = QUASIMETRICS[kind]((8,), 16, layer_norm=True)
    states = jnp.ones((2, 3))
    params = network.init(jax.random.key(0), observations=states, goals=states)

    def total(params, states, goals):
        return network.apply(params, observations=states, goals=goals).sum()

    gradients = jax.grad(total, argnums=(0, 1, 2))(params, states, states)
    assert all(np.all(np.isfinite(leaf)) for leaf in jax.tree.leaves(gradients))


@pytest.mark.parametrize("kind", QUASIMETRICS)
def test_one_set_of_states_may_meet_several_sets_of_goals(kind):
    network = QUASIMETRICS[kind]((8,), 16, layer_norm=True)
    states, goals = jnp.ones((6, 3)), jax.random.normal(jax.random.key(0), (2, 6, 3))
    params = network.init(jax.random.key(0), observations=states, goals=states)
    together = network.apply(params, observations=states, goals=goals)
    apart = [network.apply(params, observations=states, goals=goal) for goal in goals]
    np.testing.assert_allclose(together, apart, rtol=1e-5)
