import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats

from pigbench.agents.flow import FlowPolicy, VectorField, integrate, matching_loss


def test_the_loss_measures_the_distance_from_the_path_to_the_sample():
    """Where x_t and t are known, x_1 - x_0 is (x_1 - x_t) / (1 - t), whatever the draws."""
    samples = jnp.array([[1.0, -2.0, 0.5], [4.0, 0.0, 3.0]])

    def velocity(points, times):
        return (samples - points) / (1 - times)[:, None] + jnp.array([2.0, 0.0, -1.0])

    for seed in range(10):
        losses = matching_loss(velocity, samples, jax.random.key(seed))
        np.testing.assert_allclose(losses, [5.0, 5.0], rtol=1e-3)


def test_noise_is_standard_and_times_are_uniform():
    seen = {}

    def velocity(points, times):
        seen.update(points=points, times=times)
        return jnp.zeros_like(points)

    samples = jnp.full((5000, 1), 3.0)
    matching_loss(velocity, samples, jax.random.key(0))
    times = np.asarray(seen["times"])
    noise = (np.asarray(seen["points"])[:, 0] - 3 * times) / (1 - times)
    assert stats.kstest(times, "uniform").pvalue > 1e-3
    assert stats.kstest(noise, "norm").pvalue > 1e-3
    assert abs(stats.spearmanr(noise, times).statistic) < 0.05


def test_euler_steps_by_hand():
    """x' = x + t in two steps from 1: 1 + (1 + 0) / 2 = 1.5, then 1.5 + (1.5 + 0.5) / 2 = 2.5."""
    end = integrate(lambda x, t: x + t[..., None], jnp.ones((3, 1)), steps=2)
    np.testing.assert_allclose(end, 2.5)


def test_the_exact_field_of_a_gaussian_carries_noise_to_it():
    """For N(mu, sigma^2) the field is E[x_1 - x_0 | x_t], and its flow x_0 -> mu + sigma x_0."""
    mu, sigma = jnp.array([2.0, -1.0]), jnp.array([0.5, 2.0])

    def velocity(x, t):
        t = t[..., None]
        variance = (1 - t) ** 2 + (t * sigma) ** 2
        return mu + (t * sigma**2 - (1 - t)) / variance * (x - t * mu)

    noise = jax.random.normal(jax.random.key(0), (7, 3, 2))
    found = integrate(velocity, noise, steps=1000)
    np.testing.assert_allclose(found, mu + sigma * noise, atol=0.01)


def test_samples_are_the_fields_one_at_a_time():
    """`sample`, mapped over examples, against a loop over candidates, examples and steps."""
    policy = FlowPolicy((16,), 2, layer_norm=True, steps=4)
    states = jax.random.normal(jax.random.key(0), (3, 5))
    params = policy.init(jax.random.key(1), observations=states, goals=-states)
    keys = jax.random.split(jax.random.key(2), 3)

    def sample(state, key):
        return policy.sample(params, observation=state, goal=-state, count=6, key=key)

    found = jax.vmap(sample)(states, keys)
    assert found.shape == (3, 6, 2)

    field = VectorField((16,), 2, layer_norm=True)
    for n, b in np.ndindex(6, 3):
        x = jax.random.normal(keys[b], (6, 2))[n]
        for m in range(4):
            x += 0.25 * field.apply(
                params,
                observations=states[b],
                goals=-states[b],
                points=x,
                times=jnp.array(m / 4),
            )
        np.testing.assert_allclose(found[b, n], x, rtol=1e-4, atol=1e-5)


def test_samples_differ_between_candidates():
    policy = FlowPolicy((8,), 1, layer_norm=False, steps=2)
    state = jnp.ones(1)
    params = policy.init(jax.random.key(0), observations=state, goals=state)
    samples = policy.sample(params, observation=state, goal=state, count=20, key=jax.random.key(1))
    assert len(np.unique(samples)) == 20


def test_inputs_are_keyword_only():
    with pytest.raises(TypeError, match="positional"):
        VectorField((8,), 1, layer_norm=False).init(jax.random.key(0), *[jnp.zeros((1, 1))] * 4)
