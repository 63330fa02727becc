"""Trackers by name. Those that come with pigbench are imported when they are requested."""

import importlib

from pigbench.errors import lookup_own
from pigbench.names import require_new
from pigbench.trackers.tracker import Tracker

_MODULES = {
    "tensorboard": "pigbench.trackers.tensorboard",
    "wandb": "pigbench.trackers.wandb",
    "trackio": "pigbench.trackers.trackio",
}
"""Each module registers its class when it is imported."""

_TRACKERS: dict[str, type[Tracker]] = {}


def register(name: str, tracker: type[Tracker]) -> None:
    """Register a tracker as `name`. Raises UserError if the name is taken or invalid."""
    require_new("a logger", name, _TRACKERS)
    _TRACKERS[name] = tracker


def names() -> tuple[str, ...]:
    """The names of all trackers."""
    return tuple({**_MODULES, **_TRACKERS})


def get(name: str) -> type[Tracker]:
    """The tracker of that name. Raises UserError if it is unknown or not installed."""
    lookup_own("logger", dict.fromkeys(names()), name)
    if name not in _TRACKERS:
        importlib.import_module(_MODULES[name])
    return _TRACKERS[name]
