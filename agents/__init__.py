"""Offline goal-conditioned agents: losses, regularisers, networks, and the methods made of them.

The names of methods are known without JAX; what `exports` names is imported when it is asked for.
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
        # A module of this package is not imported by asking for it here.
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.exports"), name)
