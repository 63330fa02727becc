"""The scores of runs, and the choice of the evaluations from which they are computed.

Functions of results take those of `Scoring.cells`, which have only the episodes that count.
"""

import itertools
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, TypeVar

import numpy as np
from jaxtyping import Float

from pigbench.errors import UserError, lookup, require
from pigbench.evaluation.episodes import Episode
from pigbench.evaluation.measures import MEASURES
from pigbench.report import aggregates, bootstrap, stats
from pigbench.report.conditions import remarks, unequal
from pigbench.report.stats import Cell, Estimate, Result
from pigbench.seeds import Seed
from pigbench.support.grouping import grouped

_AVERAGED = 3

THRESHOLDS = (0.03, 0.05, 0.10)
"""Distances in metres, from the paper's robot experiments."""

Key = TypeVar("Key")

Curve = Mapping[int, Estimate]  # by training step, in order
TaskLabel = tuple[int, str]  # number and name
Groups = Mapping[str, Estimate | None]  # by the bars' group; None if unknown
Cells = Mapping[Cell, Sequence[Result]]


class Checkpoint(NamedTuple):
    """Which steps of a cell's curve count (none if it is too short), and the captions' wording."""

    choose: Callable[[Curve], Sequence[int]]
    wording: str


def _last_three(curve: Curve) -> list[int]:
    trained = [step for step in curve if step > 0]
    return trained[-_AVERAGED:] if len(trained) >= _AVERAGED else []


CHECKPOINTS: Mapping[str, Checkpoint] = {
    "last": Checkpoint(lambda curve: [max(curve)], "last evaluation"),
    "last-three": Checkpoint(_last_three, "average of the last three evaluations"),
    "best": Checkpoint(
        lambda curve: [max(curve, key=lambda step: curve[step].value)],
        "best checkpoint of the mean over seeds",
    ),
}


@dataclass(frozen=True)
class Scoring:
    """How runs are scored."""

    checkpoint: str = "last"
    """Evaluations that count: last, last-three (averaged), or best (by the mean over seeds)."""
    over: str = "environments"
    """Numbers per run when environments are pooled (aggregate, improvement, box and profile): one
    (environments) or one per task (tasks)."""
    bootstrap_seed: Seed = 0
    """Seed of the bootstrap for the intervals."""
    first_episodes: int | None = None
    """Count only so many episodes of each task, the first, as if no more had been evaluated."""

    def __post_init__(self) -> None:
        lookup("checkpoint", CHECKPOINTS, self.checkpoint)
        lookup("unit", UNITS, self.over)
        require(self, lambda x: x is None or x >= 1, "at least 1", "first_episodes")

    def cells(self, results: Iterable[Result]) -> dict[Cell, list[Result]]:
        """`stats.cells` of the episodes that count. Raises UserError like it."""
        return stats.cells(map(self.only_counted, results))

    def only_counted(self, result: Result) -> Result:
        """The result without the episodes of its evaluations that do not count."""
        evaluations = grouped(result.episodes, lambda episode: (episode.step, episode.task))
        kept = [one for own in evaluations.values() for one in own[: self.first_episodes]]
        return result._replace(episodes=kept)


def success(results: Sequence[Result], scoring: Scoring) -> Estimate:
    """Success rate in percent over the results of a cell, with its interval.

    Raises UserError unless all were evaluated up to the same training step.
    """
    return _estimate(_rates(results, scoring), scoring)


def task_success(results: Sequence[Result], scoring: Scoring) -> dict[TaskLabel, Estimate]:
    """Like `success`, for each task in order; the checkpoint is that of all tasks together."""
    return {task: _estimate(_rates(results, scoring, task), scoring) for task in _tasks(results)}


def milestones(results: Sequence[Result], scoring: Scoring) -> dict[str, Estimate]:
    """Like `success`, for each measure of `MEASURES` that all results have, by its label."""
    return _known(
        results,
        scoring,
        {measure.label: partial(stats.mean, measure=measure) for measure in MEASURES.values()},
    )


def by_task(results: Sequence[Result], scoring: Scoring) -> Groups:
    """`task_success` by task name."""
    return {name: value for (_, name), value in task_success(results, scoring).items()}


def by_stage(results: Sequence[Result], scoring: Scoring) -> Groups:
    """The `milestones` that are stages, from touching a cube to success."""
    found = milestones(results, scoring)
    stages = [measure.label for measure in MEASURES.values() if measure.stage]
    return {stage: found.get(stage) for stage in stages}


def thresholds(results: Sequence[Result], scoring: Scoring) -> dict[float, Estimate]:
    """Like `success`, by how far in metres cubes may be from their targets at the end.

    Empty if the episodes of some results have no final distance.
    """
    scores = {distance: partial(stats.ended_within, distance=distance) for distance in THRESHOLDS}
    return _known(results, scoring, scores)


def _known(
    results: Sequence[Result],
    scoring: Scoring,
    scores: Mapping[Key, Callable[[Sequence[Episode]], float]],
) -> dict[Key, Estimate]:
    """Estimates of the scores that all results have."""
    rates = {key: _rates(results, scoring, score=score) for key, score in scores.items()}
    return {
        key: _estimate(values, scoring)
        for key, values in rates.items()
        if not np.isnan(values).any()
    }


def stratum(results: Sequence[Result], scoring: Scoring) -> Float[np.ndarray, "run unit"]:
    """The success rates of a cell's results by unit: one for all tasks, or one of each task."""
    units = UNITS[scoring.over](results)
    return np.stack([_rates(results, scoring, unit) for unit in units], axis=-1)


def wording(cells: Cells, scoring: Scoring) -> str:
    """The checkpoint and, if that was limited, how many of its episodes count, for captions."""
    checkpoint = CHECKPOINTS[scoring.checkpoint].wording
    if scoring.first_episodes is None:
        return checkpoint
    evaluations = (stats.evaluation(group[0], _steps(group, scoring)) for group in cells.values())
    counts = sorted({count for one in evaluations for count in one[stats.EPISODES]})
    return f"{checkpoint}, {_listed(counts)} episodes per task"


def score_remarks(cells: Cells, scoring: Scoring, *, always: Collection[str] = ()) -> list[str]:
    """What readers must know who compare scores: `remarks`, and `differences`."""
    results = itertools.chain.from_iterable(cells.values())
    return [*remarks(results, always=always), *differences(cells, scoring)]


def curve_remarks(results: Iterable[Result]) -> list[str]:
    """What readers must know who compare curves, on which they see the last steps."""
    results = list(results)
    evaluations = [
        (Cell.of(result), stats.evaluation(result, {episode.step for episode in result.episodes}))
        for result in results
    ]
    return [*remarks(results), *_unequal(evaluations)]


def differences(cells: Cells, scoring: Scoring) -> list[str]:
    """Differences between the evaluations that count: values by method, for each environment."""
    return _unequal(
        [
            (
                cell,
                {"last step": [group[0].last_step]}
                | stats.evaluation(group[0], _steps(group, scoring)),
            )
            for cell, group in cells.items()
        ]
    )


def _unequal(evaluations: Sequence[tuple[Cell, Mapping[str, Sequence[int | str]]]]) -> list[str]:
    """The settings of evaluations, given by name, that differ within an environment."""
    names = dict.fromkeys(name for _, values in evaluations for name in values)
    return [
        difference
        for name in names
        for difference in unequal(
            name, ((cell, _listed(values[name])) for cell, values in evaluations)
        )
    ]


def _listed(values: Sequence[int | str]) -> str:
    return " and ".join(one if isinstance(one, str) else f"{one:,}" for one in values)


def _tasks(results: Sequence[Result]) -> list[TaskLabel]:
    return sorted({_task(episode) for episode in results[0].episodes})


def _task(episode: Episode) -> TaskLabel:
    return episode.task, episode.task_name


UNITS: Mapping[str, Callable[[Sequence[Result]], Sequence[TaskLabel | None]]] = {
    "environments": lambda results: [None],
    "tasks": _tasks,
}


def _rates(
    results: Sequence[Result],
    scoring: Scoring,
    task: TaskLabel | None = None,
    score: Callable[[Sequence[Episode]], float] = stats.success_rate,
) -> Float[np.ndarray, "run"]:
    """The success rate or another score of each result, on one task or all."""
    steps = _steps(results, scoring)
    rates = [
        [
            score(
                [
                    episode
                    for episode in result.episodes
                    if episode.step == step and task in (None, _task(episode))
                ]
            )
            for step in steps
        ]
        for result in results
    ]
    # Rounded, so that equal rates stay equal whatever the order of summation.
    return np.round(np.mean(rates, axis=-1), 9)


def _steps(results: Sequence[Result], scoring: Scoring) -> Sequence[int]:
    """The training steps of a cell's results whose evaluations count."""
    stats.require_level(results)
    steps = CHECKPOINTS[scoring.checkpoint].choose(stats.success_curve(results))
    if not steps:
        raise UserError(
            f"{results[0].run.path} has too few evaluations for checkpoint "
            f"{scoring.checkpoint!r}: use 'last'"
        )
    return steps


def _estimate(rates: Float[np.ndarray, "run"], scoring: Scoring) -> Estimate:
    bounds = bootstrap.interval([rates[:, None]], aggregates.mean, seed=scoring.bootstrap_seed)
    return stats.estimate(rates)._replace(interval=bounds)


DEFAULT = Scoring()
