"""Rewards against numbers worked by hand, and as an environment gives them."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench import envs
from pigbench.envs.rewards import Situation, place, reach, sparse
from pigbench.envs.units import metres
from pigbench.errors import UserError


def situation(*placed: bool) -> Situation:
    """The pinch point 5 and 13 cm from two cubes, which lie 10 and 20 cm from their targets."""
    return Situation(
        pinch=jnp.zeros(3),
        cubes=jnp.array([[0.03, 0.04, 0.0], [0.05, 0.12, 0.0]]),
        target=jnp.array([[0.03, 0.04, 0.1], [0.05, 0.32, 0.0]]),
        placed=jnp.array(placed),
        success=jnp.array(all(placed)),
    )


def test_reach_is_the_distance_to_the_nearest_cube():
    np.testing.assert_allclose(reach(situation(False, False)), -0.05, rtol=1e-6)


@pytest.mark.parametrize(
    ("placed", "expected"),
    [
        ((False, False), -0.3 - 0.05),
        ((True, False), -0.3 - 0.13),  # the nearer cube is where it should be
        ((True, True), -0.3),
    ],
)
def test_place_adds_the_ways_of_the_cubes_to_that_to_one_misplaced(placed, expected):
    np.testing.assert_allclose(place(situation(*placed)), expected, rtol=1e-6)


def test_sparse_is_success():
    assert (sparse(situation(True, False)), sparse(situation(True, True))) == (0.0, 1.0)


@pytest.mark.parametrize("name", ["reach", "place"])
def test_an_environment_gives_the_reward_that_is_asked_for(name):
    env = envs.make("cube-single", reward=name)
    state = env.reset_task(jax.random.key(0), 1)
    after = env.step(state, jnp.zeros(5))
    pinch, cube = (metres(after.obs[env.layout[term]]) for term in ("effector_pos", "cube_0_pos"))
    expected = -np.linalg.norm(pinch - cube)
    if name == "place":
        expected -= np.linalg.norm(cube - after.info["target"][0])
    np.testing.assert_allclose(after.reward, expected, rtol=1e-4)
    assert (float(state.reward), float(after.metrics["success"])) == (0.0, 0.0)


def test_an_unknown_reward_is_named():
    with pytest.raises(UserError, match="unknown reward 'rech': did you mean 'reach'"):
        envs.make("cube-single", reward="rech")
