"""Weights & Biases. `WANDB_PROJECT`, `WANDB_MODE=offline` and its other variables hold.

Its own steps cannot go back, as training does that goes on from a checkpoint; so the axis is
"step", a number like others.
"""

import dataclasses
import os
import secrets
from collections.abc import Mapping
from pathlib import Path

from pigbench.errors import UserError
from pigbench.support import files
from pigbench.support.extras import required
from pigbench.trackers.registry import register
from pigbench.trackers.tracker import Tracker
from pigbench.training.run import Run

(wandb,) = required("wandb", extra="wandb")

_PROJECT = "pigbench"
_ID_FILE = "wandb-id"  # in the run's folder: under which W&B knows the run


class WandB(Tracker):
    """A run of W&B, the same whenever training goes on."""

    def __init__(self, run: Run, *, step: int) -> None:
        super().__init__(run, step=step)
        try:
            self._wandb = wandb.init(
                project=os.environ.get("WANDB_PROJECT", _PROJECT),
                name=self.name,
                group=f"{run.config.environment}, {run.config.label}",
                id=_identity(run),
                resume="allow",
                reinit="create_new",  # seeds that are trained together are runs beside each other
                dir=run.path,
                config=dataclasses.asdict(run.config),
                settings=wandb.Settings(console="off", silent=True),
            )
        except wandb.Error as error:
            raise UserError(
                f"W&B takes no run: {error}; see `wandb login`, or set WANDB_MODE=offline"
            ) from None
        self._wandb.define_metric("*", step_metric="step")

    def scalars(self, step: int, values: Mapping[str, float]) -> None:
        """A row of the run's history."""
        self._wandb.log({**values, "step": step})

    def film(self, step: int, name: str, path: Path) -> None:
        """A copy of the file."""
        self._wandb.log({name: wandb.Video(str(path), format="mp4"), "step": step})

    def close(self) -> None:
        """Waits until all is sent, or on the disk."""
        self._wandb.finish()


def _identity(run: Run) -> str:
    path = run.path / _ID_FILE
    if not path.exists():
        files.write_text(path, secrets.token_hex(4))
    return files.read_text(path)


register("wandb", WandB)
