"""Trackio, in its own folder (`TRACKIO_DIR`) or, with `TRACKIO_SPACE_ID`, on the hub."""

import contextvars
import dataclasses
from collections.abc import Mapping
from pathlib import Path

from pigbench.runs.run import Run
from pigbench.support.extras import required
from pigbench.trackers.registry import register
from pigbench.trackers.tracker import Tracker

(trackio,) = required("trackio", extra="trackio")

_PROJECT = "pigbench"


class Trackio(Tracker):
    """A Trackio run, the same one whenever training resumes."""

    def __init__(self, run: Run, *, step: int) -> None:
        super().__init__(run, step=step)
        # In a context of its own: otherwise it would end the run of a seed trained beside this one.
        self._trackio = contextvars.Context().run(
            trackio.init,
            project=_PROJECT,
            name=self.name,
            group=f"{run.config.environment}, {run.config.label}",
            config=dataclasses.asdict(run.config),
            resume="allow",
        )

    def scalars(self, step: int, values: Mapping[str, float]) -> None:
        """Add a row to the run's table."""
        self._trackio.log(dict(values), step=step)

    def film(self, step: int, name: str, path: Path) -> None:
        """Add a copy of the file."""
        self._trackio.log({name: trackio.Video(path)}, step=step)

    def close(self) -> None:
        """Wait until everything is written."""
        self._trackio.finish()


register("trackio", Trackio)
