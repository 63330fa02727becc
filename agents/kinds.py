"""Options of several kinds: fields whose type is a union of dataclasses with a `kind` each."""

from collections.abc import Mapping
from typing import Any, get_args, get_type_hints


def kinds_of(config: object, field: str) -> Mapping[str, Any]:
    """The dataclasses that `field` of a configuration may hold, by their kind; none if any may."""
    parts = get_args(get_type_hints(type(config))[field])
    return {part.kind: part for part in parts if hasattr(part, "kind")}
