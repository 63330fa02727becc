"""Success rates from the evaluation episodes of runs.

The seed is the unit of replication: a run gives one number, and means and standard deviations are
over runs that differ only in their seeds.
"""

import dataclasses
import itertools
import math
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from pigbench.errors import UserError
from pigbench.evaluation import episodes
from pigbench.evaluation.episodes import Episode
from pigbench.evaluation.measures import MEASURES, Measure
from pigbench.report.bootstrap import Interval
from pigbench.runs.run import Run
from pigbench.support.compare import first_difference
from pigbench.support.grouping import grouped

EPISODES = "episodes per task"  # a name of `evaluation`


class Estimate(NamedTuple):
    """A number from `seeds` runs (the fewest of any environment).

    `deviation` is the sample standard deviation (n - 1) over seeds, `interval` the bootstrap's.
    Either is None if it is unknown: a single run has none.
    """

    value: float
    deviation: float | None = None
    interval: Interval | None = None
    seeds: int = 1


class Result(NamedTuple):
    """A run and its evaluation episodes, at least one."""

    run: Run
    episodes: Sequence[Episode]

    @property
    def representation(self) -> str | None:
        """What a hierarchical method's low level sees; None for a flat method."""
        return self.run.config.agent.get("low_level_representation")

    @property
    def last_step(self) -> int:
        """The training step of the last evaluation."""
        return max(episode.step for episode in self.episodes)


class Cell(NamedTuple):
    """What the seeds of one result share. A variant of a method counts as a method of its own."""

    method: str
    environment: str

    @classmethod
    def of(cls, result: Result) -> "Cell":
        """The cell of a result."""
        return cls(result.run.config.label, result.run.config.environment)


def read_results(runs: Iterable[Run]) -> list[Result]:
    """The runs with their episodes. Raises UserError if a run has none."""
    found = [Result(run, episodes.read_any(run.episodes_path)) for run in runs]
    empty = [str(result.run.path) for result in found if not result.episodes]
    if empty:
        raise UserError(f"no evaluation yet in {', '.join(empty)}; use `pigbench evaluate`")
    return found


def results_in_noise(result: Result) -> dict[float, Result]:
    """The run with its episodes at each evaluated noise of the estimates, in millimetres."""
    found = {level: episodes.read(path) for level, path in result.run.noise_paths().items()}
    return {level: Result(result.run, own) for level, own in found.items() if own}


def cells(results: Iterable[Result]) -> dict[Cell, list[Result]]:
    """The results of each method and environment, one per seed, sorted whatever their given order.

    Raises UserError if results to be compared are not comparable: within a cell, only the seeds may
    differ, and must, and evaluations after the same step must have the same settings; within an
    environment, the physics profile must be the same.
    """
    results = sorted(results, key=lambda result: (Cell.of(result), result.run.config.seed))
    by_cell = grouped(results, Cell.of)
    for group in by_cell.values():
        _require_alike(group, _all_but_seed)
        shared = sorted(set.intersection(*({e.step for e in one.episodes} for one in group)))
        _require_alike(group, lambda result, steps=shared: _evaluations(result, steps))
        for same in grouped(group, lambda result: result.run.config.seed).values():
            if len(same) > 1:
                raise UserError(f"{same[0].run.path} and {same[1].run.path} have the same seed")
    for group in grouped(results, lambda result: result.run.config.environment).values():
        _require_alike(group, lambda result: {"physics": result.run.config.physics})
    return by_cell


def base(method: str) -> str:
    """The method's name without its variant."""
    return method.partition(" (")[0]


def require_level(results: Sequence[Result]) -> None:
    """Raise UserError unless all results were evaluated up to the same step, on the same tasks."""
    _require_alike(
        results,
        lambda result: {
            "last evaluated step": result.last_step,
            "tasks": sorted({episode.task_name for episode in result.episodes}),
        },
    )


def evaluation(result: Result, steps: Collection[int]) -> dict[str, list[Any]]:
    """The settings of the evaluations after these training steps: all values, by name."""
    counted = [episode for episode in result.episodes if episode.step in steps]
    counts = Counter((episode.step, episode.task) for episode in counted)
    return {
        EPISODES: sorted(set(counts.values())),
        "evaluation seed": sorted({episode.seed for episode in counted}),
        "engine": sorted({episode.engine for episode in counted}),
    }


def success_curve(results: Sequence[Result]) -> dict[int, Estimate]:
    """Success rate in percent at each training step that all results of a cell have."""
    return estimate_curve([run_curve(result) for result in results])


def run_curve(result: Result) -> dict[int, float]:
    """Success rate in percent at each training step."""
    by_step = grouped(result.episodes, lambda episode: episode.step)
    return {step: success_rate(group) for step, group in by_step.items()}


def estimate_curve(curves: Sequence[Mapping[int, float]]) -> dict[int, Estimate]:
    """Mean and standard deviation of one curve per seed, at the steps that all of them have."""
    steps = sorted(set.intersection(*map(set, curves)))
    return {step: estimate([curve[step] for curve in curves]) for step in steps}


def success_rate(group: Collection[Episode]) -> float:
    """The share of successful episodes, in percent."""
    return mean(group, MEASURES["success"])


def mean(group: Iterable[Episode], measure: Measure) -> float:
    """The measure's scaled mean over the episodes in which it is known; NaN if there are none."""
    known = [e.measures[measure.name] for e in group if measure.name in e.measures]
    return measure.scale * sum(known) / len(known) if known else math.nan


def ended_within(group: Iterable[Episode], distance: float) -> float:
    """The percentage of episodes that end with all cubes within `distance` metres of their targets.

    A diverged episode has no end and counts as a failure; NaN if no episode recorded its end.
    """
    known = [
        e.measures.get("final_distance", math.inf)
        for e in group
        if "final_distance" in e.measures or e.measures.get("diverged", False)
    ]
    return 100 * sum(end <= distance for end in known) / len(known) if known else math.nan


def estimate(values: Sequence[float] | Float[np.ndarray, "run"]) -> Estimate:
    """Mean and standard deviation of one value per seed."""
    deviation = float(np.std(values, ddof=1)) if len(values) > 1 else None
    return Estimate(float(np.mean(values)), deviation, seeds=len(values))


def _all_but_seed(result: Result) -> Mapping[str, Any]:
    return dataclasses.asdict(dataclasses.replace(result.run.config, seed=0))


def _evaluations(result: Result, steps: Iterable[int]) -> Mapping[str, Any]:
    return {
        f"{name} at step {step}": values
        for step in steps
        for name, values in evaluation(result, [step]).items()
    }


def _require_alike(results: Iterable[Result], view: Callable[[Result], Mapping[str, Any]]) -> None:
    for first, second in itertools.pairwise(results):
        difference = first_difference(view(first), view(second))
        if difference is not None:
            name, left, right = difference
            raise UserError(
                f"{first.run.path} and {second.run.path} cannot be compared: "
                f"{name} is {left!r} in one and {right!r} in the other"
            )
