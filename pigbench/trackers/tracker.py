"""The interface of trackers, and the names under which they receive an evaluation's numbers.

Training metrics have their names in `metrics.jsonl`. Evaluations have "evaluation/success",
likewise every other measure of episodes, and "evaluation/task1_horizontal/success" and so on; films
have "evaluation/film/task1_horizontal/success".
"""

import abc
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from pigbench.evaluation.episodes import Episode
from pigbench.runs.run import Run
from pigbench.support.grouping import grouped

FILM = "evaluation/film"


class Tracker(abc.ABC):
    """Displays the numbers and films of one run. A context manager.

    It is made when training begins or resumes, after `step` updates: everything shown beyond that
    step will be sent again.
    """

    def __init__(self, run: Run, *, step: int) -> None:
        self.run = run

    @property
    def name(self) -> str:
        """The run's folder, as a name without slashes."""
        return str(self.run.path).strip("/.").replace("/", "-")

    @abc.abstractmethod
    def scalars(self, step: int, values: Mapping[str, float]) -> None:
        """Show numbers after `step` updates; some may not be finite."""

    def film(self, step: int, name: str, path: Path) -> None:  # noqa: B027  optional
        """Show a film, an MP4 file, of the policy after `step` updates."""

    def close(self) -> None:  # noqa: B027  optional
        """Release all resources."""

    def __enter__(self) -> "Tracker":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def evaluated(episodes: Iterable[Episode]) -> dict[str, float]:
    """The means of an evaluation's measures and each task's success, under the trackers' names."""
    rows = list(episodes)
    tasks = grouped(rows, lambda row: row.task_name)
    known = {name: None for row in rows for name in row.measures}
    return {f"evaluation/{name}": _mean(rows, name) for name in known} | {
        f"evaluation/{task}/success": _mean(own, "success") for task, own in tasks.items()
    }


def _mean(episodes: Iterable[Episode], measure: str) -> float:
    """The measure's mean over the episodes that have it."""
    return float(np.mean([e.measures[measure] for e in episodes if measure in e.measures]))
