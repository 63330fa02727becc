"""One number or one curve from the runs of all environments, as recommended by Agarwal et al. 2021.

Functions take strata as in `bootstrap` and keep the leading axes. All environments weigh the
same, however many runs they have.
"""

import math

import numpy as np
from jaxtyping import Float

from pigbench.report.bootstrap import Strata


def mean(strata: Strata) -> Float[np.ndarray | np.floating, "*batch"]:
    """The mean over environments of the mean of each one's numbers."""
    return np.mean([_flat(stratum).mean(axis=-1) for stratum in strata], axis=0)


def interquartile_mean(strata: Strata) -> Float[np.ndarray | np.floating, "*batch"]:
    """The mean without the lowest and the highest quarter of numbers, their counts rounded down.

    Each number is counted as often as gives all environments the same count: once if they have
    equally many.
    """
    flat = [_flat(stratum) for stratum in strata]
    count = math.lcm(*(own.shape[-1] for own in flat))
    numbers = np.concatenate(flat, axis=-1)
    times = np.concatenate([np.full(own.shape[-1], count // own.shape[-1]) for own in flat])
    order = np.argsort(numbers, axis=-1)
    ends = np.cumsum(times[order], axis=-1)
    quarter = count * len(flat) // 4
    kept = np.clip([ends - times[order], ends], quarter, count * len(flat) - quarter)
    return np.average(np.take_along_axis(numbers, order, axis=-1), -1, np.diff(kept, axis=0)[0])


def probability_of_improvement(
    first: Strata, second: Strata
) -> Float[np.ndarray | np.floating, "*batch"]:
    """The probability that a run of `first` is better than one of `second` in a random environment.

    The Mann-Whitney U divided by its largest value, with ties as halves, averaged over
    environments.
    """
    shares = []
    for ours, theirs in zip(first, second, strict=True):
        difference = ours[..., :, None, :] - theirs[..., None, :, :]
        shares.append((np.sign(difference).mean(axis=(-3, -2, -1)) + 1) / 2)
    return np.mean(shares, axis=0)


def profile(
    strata: Strata, thresholds: Float[np.ndarray, "threshold"]
) -> Float[np.ndarray, "*batch threshold"]:
    """The share of runs above each threshold, averaged over environments."""
    return np.mean(
        [(stratum[..., None] > thresholds).mean(axis=(-3, -2)) for stratum in strata], axis=0
    )


def _flat(
    stratum: Float[np.ndarray, "*batch run number"],
) -> Float[np.ndarray, "*batch run*number"]:
    """The numbers of all runs, one run after another."""
    return stratum.reshape(*stratum.shape[:-2], -1)
