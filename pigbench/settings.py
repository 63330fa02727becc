"""JAX's settings: those that are fixed while a command runs, and those that are recorded."""

import contextlib
import os
from collections.abc import Iterator

import jax

from pigbench import devices


@contextlib.contextmanager
def jax_defaults() -> Iterator[None]:
    """JAX's own defaults for settings that affect numbers, whatever the user has set.

    Thus the seed alone determines results. Everything here is written for single precision. Also
    usable as a decorator.
    """
    with (
        jax.enable_x64(False),
        jax.threefry_partitionable(True),
        jax.numpy_dtype_promotion("standard"),
        jax.numpy_rank_promotion("allow"),
    ):
        yield


def in_force() -> dict[str, str]:
    """What results may still depend on besides seeds and versions, ready for JSON."""
    settings = jax.config.values
    return {
        "platform": devices.backend(),
        "precision": "double" if settings["jax_enable_x64"] else "single",
        "matmul_precision": settings["jax_default_matmul_precision"] or "default",
        "XLA_FLAGS": os.environ.get("XLA_FLAGS", ""),
    }
