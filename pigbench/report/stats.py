"""Success rates from the evaluation episodes of runs.

The seed is the unit of replication: a run gives one number, and means and standard deviations are
over runs that differ in nothing but their seed.
"""

import dataclasses
import itertools
from collections import defaultdict
from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np

from pigbench.errors import UserError
from pigbench.support.compare import first_difference
from pigbench.training import episodes
from pigbench.training.episodes import Episode
from pigbench.training.run import Run

Key = TypeVar("Key", bound=Hashable)
Item = TypeVar("Item")


class Estimate(NamedTuple):
    """Mean and sample standard deviation (n - 1) over `seeds` runs; none for a single run."""

    mean: float
    deviation: float | None
    seeds: int


class Result(NamedTuple):
    """A run and its evaluation episodes, at least one."""

    run: Run
    episodes: Sequence[Episode]

    @property
    def last_step(self) -> int:
        """The training step of the last evaluation."""
        return max(episode.step for episode in self.episodes)


class Cell(NamedTuple):
    """What the seeds of one result share."""

    method: str
    environment: str


def read_results(runs: Iterable[Run]) -> list[Result]:
    """The runs with their episodes. Raises UserError when a run has none."""
    runs = list(runs)
    found = [
        Result(run, episodes.read(run.episodes_path) if run.episodes_path.exists() else [])
        for run in runs
    ]
    empty = [str(result.run.path) for result in found if not result.episodes]
    if empty:
        raise UserError(f"no evaluation yet in {', '.join(empty)}; use `pigbench evaluate`")
    return found


def cells(results: Iterable[Result]) -> dict[Cell, list[Result]]:
    """The results of each method and environment, one a seed.

    Raises UserError when results that would be set against each other are not comparable: in a cell
    only the seeds may differ, and must; in an environment the physics profile must be the same.
    """
    results = list(results)
    grouped = _group(results, lambda r: Cell(r.run.config.method, r.run.config.environment))
    for group in grouped.values():
        _require_alike(group, _all_but_seed)
        for same in _group(group, lambda result: result.run.config.seed).values():
            if len(same) > 1:
                raise UserError(f"{same[0].run.path} and {same[1].run.path} have the same seed")
    for group in _group(results, lambda result: result.run.config.environment).values():
        _require_alike(group, lambda result: {"physics": result.run.config.physics})
    return grouped


def final_success(results: Sequence[Result]) -> Estimate:
    """Success rate in percent at the last evaluation, over the results of a cell.

    Raises UserError when that is not the same training step for all.
    """
    return estimate([success_rate(_final_episodes(result)) for result in _level(results)])


def final_task_success(results: Sequence[Result]) -> dict[tuple[int, str], Estimate]:
    """As `final_success`, for each task: keys are its number and name, in order."""
    rates = defaultdict(list)
    for result in _level(results):
        by_task = _group(_final_episodes(result), lambda episode: (episode.task, episode.task_name))
        for task, group in by_task.items():
            rates[task].append(success_rate(group))
    return {task: estimate(rates[task]) for task in sorted(rates)}


def success_curve(results: Sequence[Result]) -> dict[int, Estimate]:
    """Success rate in percent at each training step at which all results of a cell have one."""
    curves = [
        {step: success_rate(group) for step, group in _group(result.episodes, _step).items()}
        for result in results
    ]
    steps = sorted(set.intersection(*map(set, curves)))
    return {step: estimate([curve[step] for curve in curves]) for step in steps}


def success_rate(group: Collection[Episode]) -> float:
    """The share of successful episodes, in percent."""
    return 100 * sum(episode.success for episode in group) / len(group)


def estimate(values: Sequence[float]) -> Estimate:
    """Mean and standard deviation of one value a seed."""
    deviation = float(np.std(values, ddof=1)) if len(values) > 1 else None
    return Estimate(float(np.mean(values)), deviation, len(values))


def _step(episode: Episode) -> int:
    return episode.step


def _final_episodes(result: Result) -> list[Episode]:
    return [episode for episode in result.episodes if episode.step == result.last_step]


def _level(results: Sequence[Result]) -> Sequence[Result]:
    _require_alike(results, lambda result: {"last evaluated step": result.last_step})
    return results


def _all_but_seed(result: Result) -> Mapping[str, Any]:
    return dataclasses.asdict(dataclasses.replace(result.run.config, seed=0))


def _require_alike(results: Iterable[Result], view: Callable[[Result], Mapping[str, Any]]) -> None:
    for first, second in itertools.pairwise(results):
        difference = first_difference(view(first), view(second))
        if difference is not None:
            name, left, right = difference
            raise UserError(
                f"{first.run.path} and {second.run.path} cannot be compared: "
                f"{name} is {left!r} in one and {right!r} in the other"
            )


def _group(items: Iterable[Item], key: Callable[[Item], Key]) -> dict[Key, list[Item]]:
    groups: dict[Key, list[Item]] = defaultdict(list)
    for item in items:
        groups[key(item)].append(item)
    return dict(groups)
