import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats

from pigbench.agents import losses


def test_td_target_by_hand():
    rewards, continuations = jnp.array([-1.0, 0.0]), jnp.array([1.0, 0.0])
    targets = losses.td_target(rewards, continuations, jnp.array([-4.0, -4.0]), discount=0.5)
    np.testing.assert_allclose(targets, [-3.0, 0.0])


def test_expectile_by_hand():
    """The sign of the advantage picks the weight; the error need not have that sign."""
    advantages, errors = jnp.array([2.0, -2.0, 0.0, -1.0]), jnp.array([3.0, 3.0, 1.0, -2.0])
    weighted = losses.expectile(advantages, errors, level=0.9)
    np.testing.assert_allclose(weighted, [8.1, 0.9, 0.9, 0.4], rtol=1e-6)


def test_expectile_regression_finds_the_expectile():
    samples = np.random.default_rng(0).exponential(size=4000)
    found = jnp.zeros(())
    slope = jax.jit(
        jax.grad(lambda m: losses.expectile(samples - m, samples - m, level=0.9).mean())
    )
    for _ in range(200):
        found -= 0.5 * slope(found)
    assert found == pytest.approx(stats.expectile(samples, 0.9), rel=1e-4)


def test_unit_gaussian_log_prob_is_scipys():
    rng = np.random.default_rng(0)
    actions, means = rng.normal(size=(2, 3, 5))
    expected = stats.norm.logpdf(actions, loc=means).sum(axis=-1)
    np.testing.assert_allclose(losses.unit_gaussian_log_prob(actions, means), expected, rtol=1e-5)


def test_awr_by_hand():
    """exp(2 x 0.5) = e; exp(2 x 3) = 403 is cut to 100, and so is what overflows."""
    advantages = jnp.array([0.0, 0.5, 3.0, 1e6])
    weighted = losses.awr(advantages, jnp.full(4, -2.0), temperature=2.0)
    np.testing.assert_allclose(weighted, [2.0, 2 * np.e, 200.0, 200.0], rtol=1e-6)


def test_awr_weights_carry_no_gradient():
    slope = jax.grad(lambda advantage: losses.awr(advantage, jnp.array(-2.0), temperature=2.0))
    assert slope(0.5) == 0
