"""Trees of arrays."""

from typing import TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import ArrayLike, Bool

Tree = TypeVar("Tree")


def where(condition: Bool[ArrayLike, ""], chosen: Tree, otherwise: Tree) -> Tree:
    """`chosen` if the condition holds, else `otherwise`."""
    return jax.tree.map(lambda x, y: jnp.where(condition, x, y), chosen, otherwise)
