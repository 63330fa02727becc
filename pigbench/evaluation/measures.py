"""The measures of an evaluation episode, which are the columns of `episodes.csv`, without JAX.

A measure is a small function of one simulation after a control step, folded over the episode. The
table is all there is to it: the rollout evaluates it, the file stores it, and tables, figures,
trackers and progress show it. The functions use only what arrays do themselves, because tables and
figures are made without JAX.
"""

import enum
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from pigbench.names import require_new

if TYPE_CHECKING:
    from pigbench.evaluation.moment import Moment

Value = bool | int | float

LIFT = 0.02
"""Metres above its start at which a cube counts as lifted: one tipped over an edge rises by 0.8 cm,
over a corner by 1.5 cm."""


class Fold(enum.Enum):
    """How a measure's values after each step are combined into the episode's."""

    EVER = enum.auto()
    LEAST = enum.auto()
    MOST = enum.auto()
    TOTAL = enum.auto()
    LAST = enum.auto()


@dataclass(frozen=True)
class Measure:
    """One number of an episode.

    Attributes:
        name: its column.
        label: its name in tables and figures, with the unit if that is not percent.
        value: the number, (), at a moment of the episode.
        fold: how the numbers of all moments are combined.
        kind: its type.
        scale: factor of its mean over episodes for display.
        stage: whether it is one of the stages from touching a cube to success.
    """

    name: str
    label: str
    value: Callable[["Moment"], Any]
    fold: Fold = Fold.EVER
    kind: type[Value] = bool
    scale: float = 100.0
    stage: bool = False


_MEASURES: dict[str, Measure] = {}

MEASURES: Mapping[str, Measure] = MappingProxyType(_MEASURES)
"""The measures in the order of columns. Distances are in metres. As for success, an episode's
initial state does not count; for a diverged episode, what it reached before diverging counts."""

BRIEF = "success", "held", "lifted"
"""Measures in the progress line of training."""


def register(measure: Measure) -> None:
    """Add a measure. Raises UserError if its name is taken or invalid."""
    require_new("a measure", measure.name, _MEASURES)
    _MEASURES[measure.name] = measure


def within(distance: float) -> Callable[["Moment"], Any]:
    """Whether every cube is within `distance` metres of its target."""
    return lambda moment: moment.from_targets.max() <= distance


def lifted(moment: "Moment") -> Any:
    """Whether a cube is held at least `LIFT` above its initial position."""
    return (moment.held & (moment.raised >= LIFT)).any()


for _measure in (
    Measure("nearest", "nearest (cm)", lambda at: at.from_pinch.min(), Fold.LEAST, float),
    Measure("touched", "touched", lambda at: at.touched.any(), stage=True),
    Measure("held", "held", lambda at: at.held.any(), stage=True),
    Measure("lifted", "lifted", lifted, stage=True),
    Measure("within_10cm", "within 10 cm", within(0.10), stage=True),
    Measure("within_5cm", "within 5 cm", within(0.05), stage=True),
    Measure("success", "success", lambda at: at.success, Fold.LAST, stage=True),
    # Not a stage: success, at 4 cm, ends an episode, so few come nearer.
    Measure("within_3cm", "within 3 cm", within(0.03)),
    Measure(
        "final_distance",
        "final (cm)",
        lambda at: at.unless_diverged(at.from_targets.max()),
        Fold.LAST,
        float,
    ),
    Measure("length", "steps", lambda at: 1, Fold.TOTAL, int, scale=1.0),
    Measure("diverged", "diverged", lambda at: at.diverged, Fold.LAST),
):
    register(_measure)
