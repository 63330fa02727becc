"""Comparison of configurations: whether they are equal, and where they differ."""

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from pigbench.errors import UserError


class Difference(NamedTuple):
    """A field, its name dotted from the outside in, and its two values ("absent" if missing)."""

    field: str
    first: Any
    second: Any


def first_difference(first: Mapping[str, Any], second: Mapping[str, Any]) -> Difference | None:
    """The first field, in the order of `first`, whose values differ as JSON; None if all agree."""
    left, right = _fields(first), _fields(second)
    for name in left | right:
        pair = left.get(name, "absent"), right.get(name, "absent")
        if pair[0] != pair[1]:
            return Difference(name, *pair)
    return None


def split(
    configs: Sequence[Mapping[str, Any]],
) -> tuple[dict[str, Any], dict[str, list[Any]]]:
    """The fields that all share, with their value, and the others, with a value for each.

    Names are dotted and values compared as in `first_difference`; a missing field is None.
    """
    every = [_fields(config) for config in configs]
    values = {
        name: [fields.get(name) for fields in every]
        for name in dict.fromkeys(name for fields in every for name in fields)
    }
    differing = {
        name: own
        for name, own in values.items()
        if any(name not in fields or fields[name] != own[0] for fields in every)
    }
    return {name: own[0] for name, own in values.items() if name not in differing}, differing


def require_same(
    what: str,
    stored: Mapping[str, Any],
    wanted: Mapping[str, Any],
    *,
    otherwise: str = "choose another folder",
) -> None:
    """Raise UserError unless `stored`, the configuration of `what`, equals `wanted`.

    The error says what to do `otherwise` than to ask for what is there.
    """
    difference = first_difference(stored, wanted)
    if difference is not None:
        name, old, new = difference
        raise UserError(
            f"{what} was made with another configuration: {name} is {old!r} there and {new!r} now; "
            f"use {old!r} to continue it, or {otherwise}"
        )


def _fields(config: Mapping[str, Any]) -> dict[str, Any]:
    # Through JSON, so that a value read from a file equals the one written: tuples become lists.
    return dict(flatten(json.loads(json.dumps(config))))


def flatten(config: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the fields of nested mappings, with names dotted from the outside in."""
    for name, value in config.items():
        if isinstance(value, Mapping):
            yield from flatten(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value
