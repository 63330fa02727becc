"""One number or one curve from the runs of all environments, as recommended by Agarwal et al. 2021.

Functions take strata as in `bootstrap`, one array (..., runs, numbers per run) per environment, and
keep the leading axes.
"""

import numpy as np

from pigbench.report.bootstrap import Strata


def mean(strata: Strata) -> np.ndarray:
    """The mean of all numbers."""
    return _pooled(strata).mean(axis=-1)


def interquartile_mean(strata: Strata) -> np.ndarray:
    """The mean without the lowest and the highest quarter of numbers, their counts rounded down."""
    numbers = np.sort(_pooled(strata), axis=-1)
    quarter = numbers.shape[-1] // 4
    return numbers[..., quarter : numbers.shape[-1] - quarter].mean(axis=-1)


def probability_of_improvement(first: Strata, second: Strata) -> np.ndarray:
    """The probability that a run of `first` is better than one of `second` in a random environment.

    The Mann-Whitney U divided by its largest value, with ties as halves, averaged over
    environments.
    """
    shares = []
    for ours, theirs in zip(first, second, strict=True):
        difference = ours[..., :, None, :] - theirs[..., None, :, :]
        shares.append((np.sign(difference).mean(axis=(-3, -2, -1)) + 1) / 2)
    return np.mean(shares, axis=0)


def profile(strata: Strata, thresholds: np.ndarray) -> np.ndarray:
    """The share of runs above each threshold, (..., thresholds), averaged over environments."""
    return np.mean(
        [(stratum[..., None] > thresholds).mean(axis=(-3, -2)) for stratum in strata], axis=0
    )


def _pooled(strata: Strata) -> np.ndarray:
    return np.concatenate([stratum.reshape(*stratum.shape[:-2], -1) for stratum in strata], axis=-1)
