"""The measures of an evaluation episode, which are the columns of `episodes.csv`, without JAX.

The table determines what the rollout evaluates, what the file stores, and what tables, figures and
progress show. A new measure is a row here and one in `milestones.FOLDED`, which computes it.
"""

from collections.abc import Mapping
from dataclasses import dataclass

Value = bool | int | float


@dataclass(frozen=True)
class Measure:
    """One number of an episode.

    Attributes:
        name: its column.
        label: its name in tables and figures, with the unit if that is not percent.
        kind: its type.
        scale: factor of its mean over episodes for display.
        stage: whether it is one of the stages from touching a cube to success.
    """

    name: str
    label: str
    kind: type[Value] = bool
    scale: float = 100.0
    stage: bool = False


MEASURES: Mapping[str, Measure] = {
    measure.name: measure
    for measure in (
        Measure("nearest", "nearest (cm)", float),
        Measure("touched", "touched", stage=True),
        Measure("held", "held", stage=True),
        Measure("lifted", "lifted", stage=True),
        Measure("within_10cm", "within 10 cm", stage=True),
        Measure("within_5cm", "within 5 cm", stage=True),
        Measure("success", "success", stage=True),
        # Not a stage: success, at 4 cm, ends an episode, so few come nearer.
        Measure("within_3cm", "within 3 cm"),
        Measure("final_distance", "final (cm)", float),
        Measure("length", "steps", int, scale=1.0),
        Measure("diverged", "diverged"),
    )
}
"""The measures in the order of columns. Distances are in metres. As for success, an episode's
initial state does not count; for a diverged episode, what it reached before diverging counts."""

BRIEF = "success", "held", "lifted"
"""Measures in the progress line of training."""
