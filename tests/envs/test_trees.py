import jax
import jax.numpy as jnp
import numpy as np

from pigbench.envs import trees


def test_each_simulation_has_all_leaves_of_one_tree():
    ones = {"pos": jnp.ones((2, 3)), "time": jnp.ones(2, int)}
    zeros = jax.tree.map(jnp.zeros_like, ones)
    found = jax.vmap(trees.where)(jnp.array([False, True]), ones, zeros)
    np.testing.assert_array_equal(found["pos"], [[0, 0, 0], [1, 1, 1]])
    np.testing.assert_array_equal(found["time"], [0, 1])
    assert found["time"].dtype == ones["time"].dtype
