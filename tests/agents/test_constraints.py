import jax.numpy as jnp
import numpy as np
import pytest

from pigbench.agents import EikonalConstraint, HJBConstraint, TransitionConstraint
from pigbench.agents.directions import Coordinates
from pigbench.agents.residuals import Transitions
from pigbench.errors import UserError
from pigbench.layout import Layout

WEIGHTS = jnp.array([[3.0, -4.0], [0.6, 0.0], [0.0, 0.0]])


def violations(constraint):
    """d = -w . s for a w each; all move by (-2, 0), and steps are 1.5, 1 and 0 long to d."""
    states = jnp.ones((3, 2))
    next_states = states - jnp.array([2.0, 0.0])
    return constraint.violations(
        lambda states: -jnp.sum(WEIGHTS * states, axis=-1),
        Transitions(states, next_states, Coordinates(Layout.of({"state": 2}), statistics=None)),
        jnp.array([1.5, 1.0, 0.0]),
    )


def test_a_step_is_at_most_1_long():
    np.testing.assert_allclose(violations(TransitionConstraint()), [0.25, 0.0, 0.0])


def test_a_gradient_is_at_most_1_steep():
    """|w| is 5, 0.6 and 0; at speed 2 it counts twice."""
    np.testing.assert_allclose(violations(EikonalConstraint()), [16.0, 0.0, 0.0])
    doubled = violations(EikonalConstraint(speed=2.0))
    np.testing.assert_allclose(doubled, [81.0, 0.04, 0.0], rtol=1e-5)


def test_distances_fall_by_1_along_motion():
    """u = (-1, 0), so the slope of d is -w_0."""
    expected = [(1 - 3.0) ** 2, (1 - 0.6) ** 2, 1.0]
    np.testing.assert_allclose(violations(HJBConstraint()), expected, rtol=1e-5)
    halved = violations(HJBConstraint(epsilon=2.0))
    np.testing.assert_allclose(halved, [(1 - 1.5) ** 2, (1 - 0.3) ** 2, 1.0], rtol=1e-5)


@pytest.mark.parametrize(
    ("kind", "arguments", "message"),
    [
        (TransitionConstraint, {"margin": -1.0}, "margin is -1.0: it must be at least 0"),
        (EikonalConstraint, {"margin": -1.0}, "margin is -1.0: it must be at least 0"),
        (EikonalConstraint, {"speed": 0.0}, "speed is 0.0: it must be positive"),
        (HJBConstraint, {"margin": -1.0}, "margin is -1.0: it must be at least 0"),
        (HJBConstraint, {"epsilon": 0.0}, "epsilon is 0.0: it must be positive"),
    ],
)
def test_bad_constants_are_named(kind, arguments, message):
    with pytest.raises(UserError, match=message):
        kind(**arguments)
