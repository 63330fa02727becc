import jax.numpy as jnp
import numpy as np
import pytest

from pigbench.agents import directions
from pigbench.agents.directions import DIRECTIONS, Coordinates
from pigbench.agents.statistics import Statistics
from pigbench.errors import UserError
from pigbench.layout import Layout

LAYOUT = Layout.of({"joint_pos": 2, "joint_vel": 1})
COORDINATES = Coordinates(
    LAYOUT,
    Statistics(np.zeros(3), np.array([3.0, 4.0, 12.0])),
    units=np.array([1.0, 0.5, 2.0]),
)
STATE, NEXT = jnp.ones((1, 3)), jnp.array([[4.0, 5.0, 13.0]])  # moved by (3, 4, 12)


@pytest.mark.parametrize(
    ("name", "length", "moving"),
    [
        ("own", 13.0, [3, 4, 12]),
        ("raw", np.sqrt(9 + 4 + 24**2), [3, 4, 12]),
        ("standardized", np.sqrt(3), [3, 4, 12]),
        ("positions", 5.0, [3, 4, 0]),
    ],
)
def test_a_displacement_over_its_length_by_hand(name, length, moving):
    direction = directions.make(name, COORDINATES)
    expected = np.array([moving]) / (length + 0.5)
    np.testing.assert_allclose(direction(STATE, NEXT, epsilon=0.5), expected, rtol=1e-6)


@pytest.mark.parametrize("name", list(DIRECTIONS))
def test_nothing_moves_in_no_direction(name):
    direction = directions.make(name, COORDINATES)
    np.testing.assert_array_equal(direction(STATE, STATE, epsilon=1e-6), np.zeros((1, 3)))


def test_a_direction_in_deviations_needs_them():
    with pytest.raises(UserError, match="direction 'standardized' needs the statistics"):
        directions.make("standardized", COORDINATES._replace(statistics=None))
    with pytest.raises(UserError, match="unknown direction 'position': did you mean 'positions'"):
        directions.make("position", COORDINATES)
