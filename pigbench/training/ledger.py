"""What training writes of one run: checkpoints, metrics, episodes, and what trackers show."""

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from pigbench.agents import TrainState
from pigbench.evaluation import episodes
from pigbench.evaluation.episodes import Episode
from pigbench.runs.checkpoints import Checkpoints
from pigbench.runs.metrics import MetricsLog
from pigbench.runs.run import Run
from pigbench.trackers import Tracker, evaluated
from pigbench.trackers.tracker import FILM
from pigbench.training.updates import MeanMetrics


@dataclass(frozen=True)
class Ledger:
    """A run and all that is open to be written of it."""

    run: Run
    checkpoints: Checkpoints
    log: MetricsLog
    trackers: Sequence[Tracker]

    @classmethod
    @contextlib.contextmanager
    def opened(
        cls, run: Run, checkpoints: Checkpoints, shown_by: Sequence[type[Tracker]], *, step: int
    ) -> Iterator["Ledger"]:
        """The ledger of a run that goes on after `step` updates."""
        with contextlib.ExitStack() as stack:
            log = stack.enter_context(MetricsLog(run.path, step=step))
            trackers = [stack.enter_context(tracker(run, step=step)) for tracker in shown_by]
            yield cls(run, checkpoints, log, trackers)

    def enter_metrics(self, step: int, metrics: MeanMetrics) -> None:
        """Log and show the mean metrics of the updates up to `step`."""
        values = {name: float(value) for name, value in metrics.items()}
        self.log.write(step, values)
        for tracker in self.trackers:
            tracker.scalars(step, values)

    def enter_evaluation(
        self, state: TrainState, rows: Sequence[Episode], films: Mapping[str, Path], *, step: int
    ) -> None:
        """Show an evaluation and its films, by name; keep its episodes, then the state itself."""
        for tracker in self.trackers:
            tracker.scalars(step, evaluated(rows))
            for name, film in films.items():
                tracker.film(step, f"{FILM}/{name}", film)
        episodes.record(self.run.episodes_path, rows)
        self.checkpoints.save(state)
