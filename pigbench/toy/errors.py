"""Errors of fits against the closed form, over the square: mean and deviation over seeds."""

import csv
import io
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from jaxtyping import Bool, Float

from pigbench.report.formats import markdown_grid
from pigbench.report.stats import Estimate, estimate
from pigbench.toy.settings import Settings
from pigbench.toy.study import ToyOutcome, grid_states

MARGIN = 0.1  # share of the half width: states farther from kinks count as away from them
LARGE = 0.1  # an error above this is large

ErrorMeasure = Callable[
    [Float[np.ndarray, "seed batch"], Bool[np.ndarray, "batch"]], Float[np.ndarray, "seed"]
]
"""Of absolute errors, and of which states are away from kinks."""

MEASURES: Mapping[str, ErrorMeasure] = {
    "mean absolute error": lambda errors, far: errors.mean(axis=-1),
    "away from kinks": lambda errors, far: errors[:, far].mean(axis=-1),
    f"share off by more than {LARGE}": lambda errors, far: (errors > LARGE).mean(axis=-1),
}

Estimates = Mapping[tuple[str, str], Mapping[str, Estimate]]


def errors(outcome: ToyOutcome, settings: Settings) -> Float[np.ndarray, "seed batch"]:
    """The fit minus d* on the grid."""
    return outcome.grid - np.asarray(outcome.mode.cost_to_go(grid_states(settings)))


def estimates(outcomes: Sequence[ToyOutcome], settings: Settings) -> Estimates:
    """Each of `MEASURES`, by the names of mode and loss."""
    return {(outcome.mode.name, outcome.loss): _measure(outcome, settings) for outcome in outcomes}


def _measure(outcome: ToyOutcome, settings: Settings) -> dict[str, Estimate]:
    sizes = np.abs(errors(outcome, settings))
    distances = np.asarray(outcome.mode.kink_distance(grid_states(settings)))
    far = distances > MARGIN * settings.half_width
    return {name: estimate(measure(sizes, far)) for name, measure in MEASURES.items()}


def markdown(found: Estimates) -> str:
    """A table with one row per mode and loss."""
    return markdown_grid(
        [
            ("mode", "loss", *MEASURES),
            *((*names, *map(_text, row.values())) for names, row in found.items()),
        ]
    )


def comma_separated(found: Estimates) -> str:
    """One row per mode, loss and measure, unrounded."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["mode", "loss", "measure", "mean", "deviation", "seeds"])
    for names, row in found.items():
        for measure, number in row.items():
            writer.writerow([*names, measure, number.value, number.deviation, number.seeds])
    return text.getvalue()


def _text(number: Estimate) -> str:
    deviation = "" if number.deviation is None else f" ± {number.deviation:.4f}"
    return f"{number.value:.4f}{deviation}"
