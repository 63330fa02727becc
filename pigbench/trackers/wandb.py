"""Weights & Biases. It obeys `WANDB_PROJECT`, `WANDB_MODE=offline` and its other variables.

Its own steps cannot go back, as training does when it resumes from a checkpoint; so the axis is
"step", logged like any other number.
"""

import dataclasses
import os
import secrets
from collections.abc import Mapping
from pathlib import Path

from pigbench.errors import UserError
from pigbench.runs.run import Run
from pigbench.support import files
from pigbench.support.extras import required
from pigbench.trackers.registry import register
from pigbench.trackers.tracker import Tracker

(wandb,) = required("wandb", extra="wandb")

_PROJECT = "pigbench"
_ID_FILE = "wandb-id"  # in the run's folder: the run's id in W&B


class WandB(Tracker):
    """A W&B run, the same one whenever training resumes."""

    def __init__(self, run: Run, *, step: int) -> None:
        super().__init__(run, step=step)
        try:
            self._wandb = wandb.init(
                project=os.environ.get("WANDB_PROJECT", _PROJECT),
                name=self.name,
                group=f"{run.config.environment}, {run.config.label}",
                id=_identity(run),
                resume="allow",
                reinit="create_new",  # seeds trained together are concurrent runs
                dir=run.path,
                config=dataclasses.asdict(run.config),
                settings=wandb.Settings(console="off", silent=True),
            )
        except wandb.Error as error:
            raise UserError(
                f"W&B accepts no run: {error}; see `wandb login`, or set WANDB_MODE=offline"
            ) from None
        self._wandb.define_metric("*", step_metric="step")

    def scalars(self, step: int, values: Mapping[str, float]) -> None:
        """Add a row to the run's history."""
        self._wandb.log({**values, "step": step})

    def film(self, step: int, name: str, path: Path) -> None:
        """Add a copy of the file."""
        self._wandb.log({name: wandb.Video(str(path), format="mp4"), "step": step})

    def close(self) -> None:
        """Wait until everything is sent or on disk."""
        self._wandb.finish()


def _identity(run: Run) -> str:
    path = run.path / _ID_FILE
    if not path.exists():
        files.write_text(path, secrets.token_hex(4))
    return files.read_text(path)


register("wandb", WandB)
