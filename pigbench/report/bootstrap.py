"""Intervals from the stratified bootstrap, which resamples the runs of each environment.

Agarwal et al. 2021, "Deep Reinforcement Learning at the Edge of the Statistical Precipice",
section 4. A run is drawn with all its numbers, so that its results on different tasks stay
together.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

Strata = Sequence[Float[np.ndarray, "*batch _run _number"]]
"""One array per environment: runs by the numbers of each run."""
Statistic = Callable[[Strata], Float[np.ndarray | np.floating, "*value"]]
"""Keeps the leading axes of the strata."""

LEVEL = 95  # percent
RESAMPLES = 2000


class Interval(NamedTuple):
    """The bounds of a number with `LEVEL` percent confidence."""

    low: float
    high: float


def interval(strata: Strata, statistic: Statistic, *, seed: int) -> Interval | None:
    """The percentile interval of a statistic that is a single number; None where `band` is."""
    bounds = band(strata, statistic, seed=seed)
    return None if bounds is None else Interval(*map(float, bounds))


def band(
    strata: Strata, statistic: Statistic, *, seed: int
) -> Float[np.ndarray, "bound=2 *value"] | None:
    """The percentile interval of each number of `statistic(strata)`: low and high.

    None if a stratum has a single run, which says nothing about how runs differ. The same seed
    gives the same draws.
    """
    if any(stratum.shape[-2] < 2 for stratum in strata):
        return None
    generator = np.random.default_rng(seed)
    drawn = [_redraw(stratum, generator) for stratum in strata]
    tail = (100 - LEVEL) / 2
    return np.percentile(statistic(drawn), [tail, 100 - tail], axis=0)


def _redraw(
    stratum: Float[np.ndarray, "run number"], generator: np.random.Generator
) -> Float[np.ndarray, "resample run number"]:
    """Runs drawn with replacement, with all their numbers."""
    runs = len(stratum)
    return stratum[generator.integers(runs, size=(RESAMPLES, runs))]
