import jax
import jax.numpy as jnp
import numpy as np

from pigbench.agents.norms import safe_norm


def test_safe_norm_and_its_gradient():
    np.testing.assert_allclose(safe_norm(jnp.array([[3.0, -4.0], [0.0, 0.0]])), [5.0, 0.0])
    np.testing.assert_allclose(jax.grad(safe_norm)(jnp.array([3.0, -4.0])), [0.6, -0.8])
    np.testing.assert_array_equal(jax.grad(safe_norm)(jnp.zeros(2)), [0.0, 0.0])
