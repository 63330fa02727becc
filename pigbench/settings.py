"""JAX's settings: those that are fixed while a command runs, and those that are recorded."""

import contextlib
import os
from collections.abc import Iterator

from pigbench import devices

_DEFAULTS = {
    "enable_x64": False,
    "threefry_partitionable": True,
    "numpy_dtype_promotion": "standard",
    "numpy_rank_promotion": "allow",
}
"""JAX's own defaults for settings that affect numbers. All code is written for single precision."""


@contextlib.contextmanager
def jax_defaults() -> Iterator[None]:
    """JAX's own defaults for settings that affect numbers, whatever the user has set.

    Thus the seed alone determines results. Also usable as a decorator.
    """
    import jax

    with contextlib.ExitStack() as stack:
        for name, value in _DEFAULTS.items():
            stack.enter_context(getattr(jax, name)(value))
        yield


def start_with_jax_defaults() -> None:
    """Let JAX, which must not have been imported yet, start with what `jax_defaults` sets."""
    os.environ.update({f"JAX_{name.upper()}": str(value) for name, value in _DEFAULTS.items()})


def in_force() -> dict[str, str]:
    """What results may still depend on besides seeds and versions, ready for JSON."""
    import jax

    settings = jax.config.values
    return {
        "platform": devices.backend(),
        "precision": "double" if settings["jax_enable_x64"] else "single",
        "matmul_precision": settings["jax_default_matmul_precision"] or "default",
        "XLA_FLAGS": os.environ.get("XLA_FLAGS", ""),
    }
