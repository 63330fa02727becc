"""Agents' stored configurations, also in the form of earlier versions.

There, an option of several kinds had the fields of all kinds. Nothing here needs JAX, because
tables read runs without it.
"""

from collections.abc import Iterator, Mapping
from typing import Any

_FIELDS: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "regularizer": {
        "none": (),
        "eikonal": ("weight", "speed"),
        "hjb": ("weight", "epsilon", "direction"),
    },
    "constraint": {
        "transition": ("margin",),
        "eikonal": ("margin", "speed"),
        "hjb": ("margin", "epsilon", "direction"),
    },
    "actor": {"ddpg+bc": ("bc_weight",), "awr": ("temperature",)},
}
"""The fields of each option's kinds."""

_DEFAULTS: Mapping[str, Any] = {
    "weight": 1.0,
    "margin": 0.05,
    "speed": 1.0,
    "epsilon": 1e-6,
    "direction": "own",
    "bc_weight": 0.3,
    "temperature": 10.0,
}

UNRECORDED: Mapping[str, Any] = {"goals": "state", "standardize": False}
"""What fields were before they existed, where they may be something else by default now."""


def upgraded(agent: Mapping[str, Any]) -> dict[str, Any]:
    """A stored configuration in today's form, which is also that of a new one.

    The fields of other kinds are left out where they have their defaults. Others are kept: whoever
    reads them says that there are no such fields.
    """
    return dict(_upgraded(_nested_actor(agent)))


def _upgraded(agent: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for name, value in agent.items():
        if not isinstance(value, Mapping):
            yield name, value
        elif value.get("kind") in [*_FIELDS.get(name, ())]:  # the kind may be anything
            yield name, _of_kind(_FIELDS[name], value)
        else:
            yield name, upgraded(value)


def _of_kind(fields: Mapping[str, tuple[str, ...]], option: Mapping[str, Any]) -> dict[str, Any]:
    others = {one for own in fields.values() for one in own} - {*fields[option["kind"]]}
    unused = {name for name in others if option.get(name) == _DEFAULTS[name]}
    return {name: value for name, value in option.items() if name not in unused}


def _nested_actor(agent: Mapping[str, Any]) -> Mapping[str, Any]:
    """The kind of a quasimetric's actor, and its constants, were fields of the agent itself."""
    kind = agent.get("actor")
    if not isinstance(kind, str) or kind not in _FIELDS["actor"]:
        return agent
    constants = {one for own in _FIELDS["actor"].values() for one in own}
    actor = {name: value for name, value in agent.items() if name in constants}
    rest = {name: value for name, value in agent.items() if name not in constants}
    return rest | {"actor": {"kind": kind, **actor}}
