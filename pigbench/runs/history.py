"""What a run was extended and resumed with, in its provenance."""

import operator
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pigbench.support import files
from pigbench.support.compare import first_difference

_RELEVANT = "versions", "commit", "machine", "numerics"
"""The parts of the provenance that results may depend on."""


def record_extension(
    path: Path, provenance: Mapping[str, Any], *, from_steps: int, steps: int
) -> None:
    """Record what a run is extended with, from `from_steps` to `steps`, in its file at `path`."""
    kept = files.read_json(path)
    extension = {"from_steps": from_steps, **provenance}
    extended = kept.get("extended", {}) | {str(steps): extension}
    files.write_json(path, kept | {"extended": extended})


def record_resumption(path: Path, provenance: Mapping[str, Any], *, step: int) -> str | None:
    """Record what a run is resumed with after `step` updates, if it differs from before.

    Returns the first difference, in words; None if there is none.
    """
    kept = files.read_json(path)
    difference = first_difference(_relevant(_latest(kept)), _relevant(provenance))
    if difference is None:
        return None
    resumed = kept.get("resumed", {}) | {str(step): provenance}
    files.write_json(path, kept | {"resumed": resumed})
    name, before, now = difference
    return f"{name} was {before!r} and is {now!r}"


def _latest(kept: Mapping[str, Any]) -> Mapping[str, Any]:
    """The part of a run's provenance that it was last trained with."""
    later = [
        *((int(step), one) for step, one in kept.get("resumed", {}).items()),
        *((one["from_steps"], one) for one in kept.get("extended", {}).values()),
    ]
    return max(later, key=operator.itemgetter(0), default=(0, kept))[1]


def _relevant(provenance: Mapping[str, Any]) -> dict[str, Any]:
    return {name: provenance[name] for name in _RELEVANT if name in provenance}
