"""What a tracker is, and under which names it is given the numbers of an evaluation.

Training metrics have the names that `metrics.jsonl` has; evaluations come as
"evaluation/success", each further measure of episodes, "evaluation/task1_horizontal/success" and
so on, and films as "evaluation/film/task1_horizontal/success".
"""

import abc
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from pigbench.training.episodes import Episode
from pigbench.training.run import Run

FILM = "evaluation/film"


class Tracker(abc.ABC):
    """Shows the numbers and films of one run. A context manager.

    It is made as training begins or goes on, after `step` updates: of what was shown beyond, all
    comes again.
    """

    def __init__(self, run: Run, *, step: int) -> None:
        self.run = run

    @property
    def name(self) -> str:
        """The run's folder, as a name without slashes."""
        return str(self.run.path).strip("/.").replace("/", "-")

    @abc.abstractmethod
    def scalars(self, step: int, values: Mapping[str, float]) -> None:
        """Shows numbers after so many updates; some may not be finite."""

    def film(self, step: int, name: str, path: Path) -> None:  # noqa: B027  optional
        """Shows a film, a file in MP4, of the policy after so many updates."""

    def close(self) -> None:  # noqa: B027  optional
        """Lets go of all it holds."""

    def __enter__(self) -> "Tracker":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def evaluated(episodes: Iterable[Episode]) -> dict[str, float]:
    """The means of an evaluation's measures, and each task's success, by the trackers' names."""
    rows = list(episodes)
    tasks = {row.task_name: [r for r in rows if r.task_name == row.task_name] for row in rows}
    known = {name: None for row in rows for name in row.measures}
    return {f"evaluation/{name}": _mean(rows, name) for name in known} | {
        f"evaluation/{task}/success": _mean(own, "success") for task, own in tasks.items()
    }


def _mean(episodes: Iterable[Episode], measure: str) -> float:
    """Over the episodes that have it."""
    return float(np.mean([e.measures[measure] for e in episodes if measure in e.measures]))
