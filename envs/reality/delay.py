"""A delay of whole control steps: what goes in comes out so many steps later."""

import jax
import jax.numpy as jnp


def begin(first: jax.Array, steps: int) -> jax.Array:
    """A line (steps, ...) on its way out, as if `first` (...) had gone in all along."""
    return jnp.broadcast_to(first, (steps, *first.shape))


def push(line: jax.Array, new: jax.Array) -> tuple[jax.Array, jax.Array]:
    """The line a control step later, with `new` (...) gone in, and what came out of it."""
    longer = jnp.concatenate([line, new[None]])
    return longer[1:], longer[0]
