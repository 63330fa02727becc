"""What an evaluation episode is measured by: the columns of `episodes.csv`, known without JAX.

What the rollout evaluates, the file holds and tables, figures and progress show follows from the
table: a new measure is a row in it, and one in `milestones.FOLDED`, which says how it is found.
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
        scale: what its mean over episodes is multiplied by where it is shown.
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
        # No stage: success, at 4 cm, ends an episode, so few come nearer.
        Measure("within_3cm", "within 3 cm"),
        Measure("final_distance", "final (cm)", float),
        Measure("length", "steps", int, scale=1.0),
        Measure("diverged", "diverged"),
    )
}
"""In the order of columns. Distances are in metres; the state that an episode begins in does not
count, as it does not for success; of a diverged episode counts what it reached before."""

BRIEF = "success", "held", "lifted"
"""Measures in the line of a training's progress."""
