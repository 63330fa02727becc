"""XLA flags to set before JAX starts."""

import importlib.metadata
import os
import sys
import warnings

FAULTY = ("0.10.2", "0.11.0")
"""The jaxlibs whose fused reductions on a CPU are wrong or crash (jax-ml/jax#39103, #39257)."""

_FUSION = "--xla_cpu_experimental_ynn_fusion_type"
CURE = f"{_FUSION}=-reduce"


def avoid_wrong_sums() -> None:
    """Switch the faulty fusion off in `XLA_FLAGS`, unless the flags already set it.

    XLA reads the flags once: if JAX is already running, this cannot be done, and a warning says so.
    """
    version = importlib.metadata.version("jaxlib")
    flags = os.environ.get("XLA_FLAGS", "")
    if version not in FAULTY or _FUSION in flags:
        return
    if _jax_runs():
        # The flag must not be set now: JAX would file wrong programs under it in its cache.
        warnings.warn(
            f"jaxlib {version} computes some sums wrongly on a CPU, and JAX started before "
            f"pigbench could prevent it: import pigbench first, or set XLA_FLAGS={CURE}",
            stacklevel=3,
        )
        return
    os.environ["XLA_FLAGS"] = f"{flags} {CURE}".strip()


def _jax_runs() -> bool:
    bridge = sys.modules.get("jax._src.xla_bridge")
    return bridge is not None and bridge.backends_are_initialized()
