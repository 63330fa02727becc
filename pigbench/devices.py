"""The device that JAX runs on. Every layer of the package may import this module, without JAX."""

import os

from pigbench.errors import UserError


def backend() -> str:
    """JAX's name for it: cpu, gpu or tpu. Raises UserError if the requested one is missing."""
    import jax

    try:
        return jax.default_backend()
    # JAX fails with an assertion if no installed package knows what JAX_PLATFORMS names.
    except (RuntimeError, AssertionError) as error:
        asked = os.environ.get("JAX_PLATFORMS", "")
        reason = str(error).split("\n")[0] or "there is no such device, or no package for it"
        raise UserError(f"JAX cannot run with JAX_PLATFORMS={asked!r}: {reason}") from None
