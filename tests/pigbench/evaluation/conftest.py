"""An agent that acts at random."""

import jax
import pytest


class Drawn:
    """An agent whose actions are random."""

    def act(self, params, observation, goal, key):
        return jax.random.uniform(key, (5,), minval=-1, maxval=1)


@pytest.fixture
def drawn() -> Drawn:
    return Drawn()
