"""Trackio, in its own folder (`TRACKIO_DIR`) or, with `TRACKIO_SPACE_ID`, on the hub."""

import contextvars
import dataclasses
from collections.abc import Mapping
from pathlib import Path

from pigbench.support.extras import required
from pigbench.trackers.registry import register
from pigbench.trackers.tracker import Tracker
from pigbench.training.run import Run

(trackio,) = required("trackio", extra="trackio")

_PROJECT = "pigbench"


class Trackio(Tracker):
    """A run of Trackio, the same whenever training goes on."""

    def __init__(self, run: Run, *, step: int) -> None:
        super().__init__(run, step=step)
        # In a context of its own: else it would end the run of a seed trained beside this one.
        self._trackio = contextvars.Context().run(
            trackio.init,
            project=_PROJECT,
            name=self.name,
            group=f"{run.config.environment}, {run.config.label}",
            config=dataclasses.asdict(run.config),
            resume="allow",
        )

    def scalars(self, step: int, values: Mapping[str, float]) -> None:
        """A row of the run's table."""
        self._trackio.log(dict(values), step=step)

    def film(self, step: int, name: str, path: Path) -> None:
        """A copy of the file."""
        self._trackio.log({name: trackio.Video(path)}, step=step)

    def close(self) -> None:
        """Waits until all is written."""
        self._trackio.finish()


register("trackio", Trackio)
