"""The device that JAX runs on. Every floor of the package may import this module."""

import os

import jax

from pigbench.errors import UserError


def backend() -> str:
    """What JAX calls it: cpu, gpu or tpu. Raises UserError where what is asked for is not there."""
    try:
        return jax.default_backend()
    # JAX fails by an assertion where JAX_PLATFORMS names what no installed package knows.
    except (RuntimeError, AssertionError) as error:
        asked = os.environ.get("JAX_PLATFORMS", "")
        reason = str(error).split("\n")[0] or "there is no such device, or no package for it"
        raise UserError(f"JAX cannot run with JAX_PLATFORMS={asked!r}: {reason}") from None
