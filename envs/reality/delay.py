"""A delay line: what goes in comes out a fixed number of control steps later."""

import jax.numpy as jnp
from jaxtyping import Array, Float


def begin(first: Float[Array, "*item"], steps: int) -> Float[Array, "delay *item"]:
    """A delay line of so many steps, filled with `first`."""
    return jnp.broadcast_to(first, (steps, *first.shape))


def push(
    line: Float[Array, "delay *item"], new: Float[Array, "*item"]
) -> tuple[Float[Array, "delay *item"], Float[Array, "*item"]]:
    """The line one control step later, after `new` went in, and what came out."""
    longer = jnp.concatenate([line, new[None]])
    return longer[1:], longer[0]
