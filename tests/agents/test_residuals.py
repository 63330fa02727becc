import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench.agents.networks import Value
from pigbench.agents.residuals import eikonal_residual, gradient_norm, hjb_residual


@pytest.fixture
def value(float64):
    """V(., g) of a freshly initialised network in double precision, for a batch of 6 states."""
    network = Value((32, 32), layer_norm=True)
    goals = jax.random.normal(jax.random.key(1), (6, 4))
    params = network.init(jax.random.key(0), observations=goals, goals=goals)
    params = jax.tree.map(lambda leaf: leaf.astype(jnp.float64), params)
    return lambda states: network.apply(params, observations=states, goals=goals)


def states_and_next():
    rng = np.random.default_rng(0)
    states = rng.normal(size=(6, 4))
    return states, states + 0.1 * rng.normal(size=(6, 4))


def slope(value, states, directions, h=1e-5):
    return (value(states + h * directions) - value(states - h * directions)) / (2 * h)


def test_gradient_norm_against_finite_differences(value):
    states, _ = states_and_next()
    partials = [slope(value, states, axis) for axis in np.eye(4)]
    values, norms = gradient_norm(value, states)
    np.testing.assert_allclose(norms, np.linalg.norm(partials, axis=0), rtol=1e-7)
    np.testing.assert_array_equal(values, value(states))


def test_hjb_residual_against_finite_differences(value):
    states, next_states = states_and_next()
    moves = next_states - states
    directions = moves / (np.linalg.norm(moves, axis=-1, keepdims=True) + 0.05)
    values, residuals = hjb_residual(value, states, next_states, epsilon=0.05)
    cost_slopes = -slope(value, states, directions)
    np.testing.assert_allclose(residuals, (cost_slopes + 1) ** 2, rtol=1e-7)
    np.testing.assert_allclose(values, value(states), rtol=1e-12)


def test_eikonal_residual_by_hand():
    """V = w . s with |w| = 5: (5 S - 1)^2, whose slope in w is 2 (5 S - 1) S w / 5."""
    weights = jnp.array([3.0, -4.0])

    def residuals(weights, speed):
        return eikonal_residual(lambda states: states @ weights, jnp.ones((2, 2)), speed=speed)[1]

    np.testing.assert_allclose(residuals(weights, 1.0), [16.0, 16.0])
    np.testing.assert_allclose(residuals(weights, jnp.array([0.2, 0.4])), [0.0, 1.0], atol=1e-12)
    gradient = jax.grad(lambda weights: residuals(weights, 1.0)[0])(weights)
    np.testing.assert_allclose(gradient, [4.8, -6.4], rtol=1e-6)


def test_hjb_residual_by_hand():
    """V = w . s; a move along the first axis sees w_0 only, whatever its length."""
    states = jnp.zeros((3, 2))
    next_states = jnp.array([[0.01, 0.0], [5.0, 0.0], [0.0, -2.0]])

    def residuals(weights):
        return hjb_residual(lambda states: states @ weights, states, next_states, epsilon=1e-9)[1]

    weights = jnp.array([3.0, 1.0])
    np.testing.assert_allclose(residuals(weights), [4.0, 4.0, 4.0], rtol=1e-5)
    np.testing.assert_allclose(
        jax.jacobian(residuals)(weights), [[4.0, 0.0], [4.0, 0.0], [0.0, 4.0]], rtol=1e-5
    )
