"""JAX's settings."""

import contextlib
from collections.abc import Iterator

import jax


@contextlib.contextmanager
def jax_defaults() -> Iterator[None]:
    """JAX's own defaults for what numbers depend on, whatever the user has set; also a decorator.

    So the seed alone decides, and single precision is what everything here is written for.
    """
    with (
        jax.enable_x64(False),
        jax.threefry_partitionable(True),
        jax.numpy_dtype_promotion("standard"),
        jax.numpy_rank_promotion("allow"),
    ):
        yield
