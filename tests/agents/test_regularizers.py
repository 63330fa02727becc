import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench.agents import EikonalRegularizer, HJBRegularizer, NoRegularizer
from pigbench.agents.directions import Coordinates
from pigbench.agents.residuals import Transitions
from pigbench.errors import UserError
from pigbench.layout import Layout

PLAIN = Coordinates(Layout.of({"state": 2}), statistics=None)


@pytest.mark.parametrize("regularizer", [EikonalRegularizer(), HJBRegularizer()])
def test_gradients_are_finite_where_nothing_moves_and_the_value_is_flat(regularizer):
    states = jnp.ones((2, 3))

    def loss(weights):
        return regularizer.residuals(
            lambda states: states @ weights, Transitions(states, states, PLAIN)
        )[1].sum()

    residual, gradient = jax.value_and_grad(loss)(jnp.zeros(3))
    assert residual == 2
    np.testing.assert_array_equal(gradient, 0)


def test_no_regularizer_leaves_the_value_alone():
    states = jnp.arange(4.0).reshape(2, 2)
    values, residuals = NoRegularizer().residuals(
        lambda states: states.sum(axis=-1), Transitions(states, states + 1, PLAIN)
    )
    np.testing.assert_array_equal(values, [1.0, 5.0])
    np.testing.assert_array_equal(residuals, 0)


def test_constants_reach_the_residual():
    states = jnp.zeros((1, 2))
    next_states = jnp.array([[3.0, 4.0]])

    def residual(regularizer):
        _, residuals = regularizer.residuals(
            lambda states: 2 * states[:, 0], Transitions(states, next_states, PLAIN)
        )
        return residuals.item()

    assert residual(EikonalRegularizer(speed=2.0)) == pytest.approx((2 * 2 - 1) ** 2)
    assert residual(HJBRegularizer(epsilon=5.0)) == pytest.approx((1 - 2 * 0.3) ** 2)


@pytest.mark.parametrize(
    ("kind", "arguments", "message"),
    [
        (EikonalRegularizer, {"weight": -1.0}, "weight is -1.0: it must be at least 0"),
        (EikonalRegularizer, {"speed": 0.0}, "speed is 0.0: it must be positive"),
        (HJBRegularizer, {"weight": -1.0}, "weight is -1.0: it must be at least 0"),
        (HJBRegularizer, {"epsilon": 0.0}, "epsilon is 0.0: it must be positive"),
        (HJBRegularizer, {"direction": "positon"}, "did you mean 'positions'"),
    ],
)
def test_bad_constants_are_named(kind, arguments, message):
    with pytest.raises(UserError, match=message):
        kind(**arguments)


@pytest.mark.parametrize(
    ("kind", "field"),
    [(NoRegularizer, "weight"), (EikonalRegularizer, "epsilon"), (HJBRegularizer, "speed")],
)
def test_a_constant_of_another_kind_is_refused(kind, field):
    with pytest.raises(TypeError, match=field):
        kind(**{field: 1.0})
