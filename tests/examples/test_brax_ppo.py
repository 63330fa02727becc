"""The example of Brax's PPO: what it adds to an environment. A training takes minutes."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench import envs
from pigbench.envs.units import POSITION_SCALE


@pytest.fixture(scope="module")
def example(load):
    return load("brax_ppo")


def test_the_ways_to_the_goal_are_observed(example):
    env = example.WithGoal(envs.make("cube-double", reward="place"))
    state = env.reset(jax.random.PRNGKey(0))
    assert state.obs.shape == (env.observation_size,) == (37 + 6,)
    place = env.env.layout["cube_1_pos"]
    cube = state.obs[place] / POSITION_SCALE
    way = state.info["goal"][place] / POSITION_SCALE - cube
    np.testing.assert_allclose(state.obs[-3:] / POSITION_SCALE, way, atol=1e-6)


def test_brax_gets_the_function_back_that_jax_has_no_longer(example):
    tree = {"a": jnp.arange(3.0), "b": 2.0}
    copies = jax.device_put_replicated(tree, jax.devices()[:1] * 2)
    np.testing.assert_array_equal(copies["a"], [[0, 1, 2]] * 2)
    np.testing.assert_array_equal(copies["b"], [2, 2])
    ran = jax.pmap(lambda x: x["a"] + x["b"])(example.replicate(tree, jax.local_devices()))
    np.testing.assert_array_equal(ran[0], [2, 3, 4])
