"""Comparison of methods over all environments that they have in common."""

import itertools
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from pigbench.errors import UserError
from pigbench.report import aggregates, bootstrap
from pigbench.report.bootstrap import Statistic, Strata
from pigbench.report.scoring import Cells, Scoring, stratum
from pigbench.report.stats import Cell, Estimate

AGGREGATES: Mapping[str, Statistic] = {
    "IQM": aggregates.interquartile_mean,
    "mean": aggregates.mean,
}


class Pool(NamedTuple):
    """The success rates of each method in percent, one stratum per environment."""

    environments: Sequence[str]
    strata: Mapping[str, Strata]


class Profile(NamedTuple):
    """The percentage of runs above each threshold, and its interval, low and high."""

    share: Float[np.ndarray, "threshold"]
    band: Float[np.ndarray, "2 threshold"] | None


def pool(cells: Cells, scoring: Scoring) -> Pool:
    """The success rates in cells of `common`."""
    environments = sorted({cell.environment for cell in cells})
    return Pool(
        environments,
        {
            method: [
                stratum(cells[Cell(method, environment)], scoring) for environment in environments
            ]
            for method in sorted({cell.method for cell in cells})
        },
    )


def common(cells: Cells) -> Cells:
    """The cells in environments that all methods have. Raises UserError if there is none."""
    environments = common_environments(cells)
    if not environments:
        methods = sorted({cell.method for cell in cells})
        raise UserError(f"no environment has runs of all methods: {', '.join(methods)}")
    return {cell: group for cell, group in cells.items() if cell.environment in environments}


def has_common_environment(cells: Cells) -> bool:
    """Whether there is an environment that all methods have."""
    return bool(common_environments(cells))


def has_comparable_methods(cells: Cells) -> bool:
    """Whether there are several methods, and an environment that all have."""
    return has_common_environment(cells) and len({cell.method for cell in cells}) > 1


def common_environments(cells: Collection[Cell]) -> list[str]:
    """The environments that all methods have."""
    methods = {cell.method for cell in cells}
    return sorted(
        environment
        for environment in {cell.environment for cell in cells}
        if all(Cell(method, environment) in cells for method in methods)
    )


def aggregated(pooled: Pool, scoring: Scoring) -> dict[tuple[str, str], Estimate]:
    """Each of `AGGREGATES` in percent, by method and name."""
    return {
        (method, name): _estimate(strata, measure, scoring)
        for method, strata in pooled.strata.items()
        for name, measure in AGGREGATES.items()
    }


def improvements(pooled: Pool, scoring: Scoring) -> dict[tuple[str, str], Estimate]:
    """The probability that the first method of a pair is better than the second, in percent.

    Raises UserError if there is only one method.
    """
    if len(pooled.strata) < 2:
        raise UserError("improvement compares methods: give runs of at least two")

    def measure(both: Strata) -> Float[np.ndarray | np.floating, "*batch"]:
        half = len(pooled.environments)
        return 100 * aggregates.probability_of_improvement(both[:half], both[half:])

    return {
        (first, second): _estimate(
            [*pooled.strata[first], *pooled.strata[second]], measure, scoring
        )
        for first, second in itertools.permutations(pooled.strata, 2)
    }


def profiles(
    pooled: Pool, thresholds: Float[np.ndarray, "threshold"], scoring: Scoring
) -> dict[str, Profile]:
    """The performance profile of each method over `thresholds`, in percent."""

    def measure(strata: Strata) -> Float[np.ndarray, "*batch threshold"]:
        return 100 * aggregates.profile(strata, thresholds)

    return {
        method: Profile(
            measure(strata), bootstrap.band(strata, measure, seed=scoring.bootstrap_seed)
        )
        for method, strata in pooled.strata.items()
    }


def _estimate(strata: Strata, measure: Statistic, scoring: Scoring) -> Estimate:
    return Estimate(
        float(measure(strata)),
        interval=bootstrap.interval(strata, measure, seed=scoring.bootstrap_seed),
        seeds=min(map(len, strata)),
    )
