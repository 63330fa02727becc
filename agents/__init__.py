"""Offline goal-conditioned agents: losses, regularisers, networks, and the methods built from them.

Method names are available without importing JAX; the names in `exports` are imported on first use.
"""

import importlib
import importlib.util
from typing import TYPE_CHECKING, Any

from pigbench.agents.catalogue import names as names
from pigbench.agents.catalogue import summaries as summaries

if TYPE_CHECKING:
    from pigbench.agents.exports import *  # noqa: F403


def __getattr__(name: str) -> Any:
    if name.startswith("__") or importlib.util.find_spec(f"{__name__}.{name}"):
        # Submodules must be imported explicitly.
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.exports"), name)
