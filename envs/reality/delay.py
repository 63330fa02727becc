"""A delay line: what goes in comes out a fixed number of control steps later."""

import jax
import jax.numpy as jnp


def begin(first: jax.Array, steps: int) -> jax.Array:
    """A delay line (steps, ...) filled with `first` (...)."""
    return jnp.broadcast_to(first, (steps, *first.shape))


def push(line: jax.Array, new: jax.Array) -> tuple[jax.Array, jax.Array]:
    """The line one control step later, after `new` (...) went in, and what came out."""
    longer = jnp.concatenate([line, new[None]])
    return longer[1:], longer[0]
