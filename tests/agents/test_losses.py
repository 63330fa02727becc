import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats

from pigbench.agents import losses


@pytest.mark.parametrize(("goal_reward", "expected"), [(0.0, [-3.0, 0.0]), (1.0, [-2.0, 1.0])])
def test_goal_td_target_by_hand(goal_reward, expected):
    """A step costs 1, or a reward is at the goal; nothing counts that lies beyond the goal."""
    success, next_values = jnp.array([0.0, 1.0]), jnp.array([-4.0, -4.0])
    targets = losses.goal_td_target(success, next_values, discount=0.5, goal_reward=goal_reward)
    np.testing.assert_allclose(targets, expected)


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


def test_push_by_hand():
    """log(1 + e^(2 (3 - d))) / 2; far below the offset it falls by 1 with each unit of distance."""
    pushes = losses.push_apart(jnp.array([3.0, 2.5, -97.0, 103.0]), offset=3.0, beta=2.0)
    np.testing.assert_allclose(pushes, [np.log(2) / 2, np.log(1 + np.e) / 2, 100.0, 0.0], atol=1e-6)


def test_hinge_by_hand():
    np.testing.assert_allclose(losses.hinge(jnp.array([-2.0, 0.0, 3.0])), [0.0, 0.0, 9.0])


def test_lagrangian_descends_in_the_violation_and_climbs_in_the_multiplier():
    """lambda = e^0.7: slopes are lambda, and lambda (margin - violation) in the logarithm."""

    def lagrangian(log_multiplier, violation):
        return losses.lagrangian(log_multiplier, violation, margin=0.5)

    slopes = jax.grad(lagrangian, argnums=(0, 1))(0.7, 3.0)
    np.testing.assert_allclose(slopes, [np.exp(0.7) * (0.5 - 3.0), np.exp(0.7)], rtol=1e-6)


def test_gradient_descent_on_a_lagrangian_meets_the_constraint():
    """The least -x with x^2 <= 4 is at x = 2, where the multiplier balances 1 with 2 x lambda."""

    def loss(variables):
        log_multiplier, x = variables
        return -x + losses.lagrangian(log_multiplier, x**2, margin=4.0)

    @jax.jit
    def descend(variables):
        return jax.lax.fori_loop(0, 3000, lambda _, v: v - 0.02 * jax.grad(loss)(v), variables)

    log_multiplier, x = descend(jnp.array([0.0, 0.5]))
    assert x == pytest.approx(2.0, rel=1e-3)
    assert np.exp(log_multiplier) == pytest.approx(0.25, rel=1e-3)


def test_implicit_value_by_hand():
    """Backups -1 + 0.5 V': -2 and -3 for the members, 0 at the goal.

    The least backup, -3, lies below the targets' mean, -2.5; at the goal it lies above.
    """
    loss = losses.implicit_value(
        jnp.array([[-4.0, -1.0], [-1.0, -2.0]]),
        jnp.array([[-2.0, -3.0], [-3.0, -3.0]]),
        jnp.array([[-2.0, -9.0], [-4.0, -9.0]]),
        jnp.array([0.0, 1.0]),
        discount=0.5,
        level=0.9,
    )
    np.testing.assert_allclose(loss, [0.1 * (2**2 + 2**2), 0.9 * (1**2 + 2**2)], rtol=1e-6)
