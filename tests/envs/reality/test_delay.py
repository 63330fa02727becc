"""What goes in comes out so many steps later."""

import jax.numpy as jnp
import numpy as np
import pytest

from pigbench.envs.reality import delay


@pytest.mark.parametrize("steps", [0, 1, 3])
def test_what_goes_in_comes_out_later(steps):
    line, out = delay.begin(jnp.array([7.0, 8.0]), steps), []
    for number in range(5):
        line, due = delay.push(line, jnp.full(2, float(number)))
        out.append(due)
    expected = [[7.0, 8.0]] * steps + [[number] * 2 for number in range(5 - steps)]
    np.testing.assert_array_equal(out, expected)
