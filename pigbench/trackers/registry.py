"""Trackers by name. Those that come with pigbench are imported when they are asked for."""

import importlib

from pigbench.errors import UserError, lookup
from pigbench.names import check
from pigbench.trackers.tracker import Tracker

_MODULES = {
    "tensorboard": "pigbench.trackers.tensorboard",
    "wandb": "pigbench.trackers.wandb",
    "trackio": "pigbench.trackers.trackio",
}
"""Each registers its class as it is imported."""

_TRACKERS: dict[str, type[Tracker]] = {}


def register(name: str, tracker: type[Tracker]) -> None:
    """Make a tracker known under `name`; `UserError` if that is taken, or no name."""
    check("a logger", name)
    if name in _TRACKERS:
        raise UserError(f"logger {name!r} is already registered: choose another name")
    _TRACKERS[name] = tracker


def names() -> tuple[str, ...]:
    """The names of all trackers."""
    return tuple({**_MODULES, **_TRACKERS})


def get(name: str) -> type[Tracker]:
    """The tracker of that name. Raises `UserError` if there is none, or it is not installed."""
    lookup("logger", dict.fromkeys(names()), name)
    if name not in _TRACKERS:
        importlib.import_module(_MODULES[name])
    return _TRACKERS[name]
