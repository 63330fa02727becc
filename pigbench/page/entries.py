"""The training runs that a page shows, finished or not, read from their files alone."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from pigbench.errors import UserError
from pigbench.evaluation import episodes
from pigbench.evaluation.episodes import Episode
from pigbench.report.stats import Result, success_rate
from pigbench.runs.run import Run, read_run
from pigbench.suite import spec
from pigbench.suite.status import CUT_OFF, DONE, RUNNING, status
from pigbench.support.lock import is_held


class Saved(NamedTuple):
    """A run and its evaluation episodes, of which there may be none yet."""

    run: Run
    episodes: Sequence[Episode]


class Entry(NamedTuple):
    """A training run: its state, its updates so far and in total, its last success in percent.

    `saved` is None if nothing can be read yet.
    """

    name: str
    state: str
    steps: int
    total: int
    success: float | None
    saved: Saved | None

    @property
    def done(self) -> bool:
        """Whether it is trained and evaluated to the end."""
        return self.state == DONE

    @property
    def result(self) -> Result | None:
        """The run with its episodes, once it has any."""
        return Result(*self.saved) if self.saved and self.saved.episodes else None


def read(folders: Iterable[Path]) -> list[Entry]:
    """The training runs in the folders of runs and of suites.

    Raises UserError if a folder is neither, or if a run's files are torn.
    """
    return [
        entry
        for folder in folders
        for entry in (_of_suite(folder) if is_suite(folder) else [_of_run(folder)])
    ]


def is_suite(folder: Path) -> bool:
    """Whether the folder contains a suite."""
    return (folder / spec.KEPT).exists()


def _of_run(folder: Path) -> Entry:
    saved = _saved(folder)
    total = saved.run.config.steps
    step = max((episode.step for episode in saved.episodes), default=0)
    last = [episode for episode in saved.episodes if episode.step == step]
    unfinished = RUNNING if is_held(folder) else CUT_OFF
    state = DONE if last and step >= total else unfinished
    return Entry(str(folder), state, step, total, success_rate(last) if last else None, saved)


def _of_suite(folder: Path) -> Iterator[Entry]:
    suite = spec.read_kept(folder / spec.KEPT)
    for cell, state, steps, success in status(suite, folder):
        try:
            saved = _saved(folder / cell.name)
        except UserError:
            if state == DONE:
                raise
            saved = None  # nothing is there yet, or its files are what made it fail
        yield Entry(cell.name, state, steps, cell.environment.steps, success, saved)


def _saved(folder: Path) -> Saved:
    run = read_run(folder)
    return Saved(run, episodes.read_any(run.episodes_path))
