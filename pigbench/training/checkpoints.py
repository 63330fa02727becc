"""Training states on disk, by Orbax: written whole or not at all; the last one is kept."""

from pathlib import Path
from typing import cast

import orbax.checkpoint as ocp

from pigbench.agents import TrainState
from pigbench.errors import UserError
from pigbench.support import files


class Checkpoints:
    """The checkpoints of a run's folder. A context manager."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        options = ocp.CheckpointManagerOptions(max_to_keep=1, enable_async_checkpointing=False)
        with files.explaining_full_disk(folder):
            self._manager = ocp.CheckpointManager(folder.absolute(), options=options)

    def save(self, state: TrainState) -> None:
        """Keep `state`, complete on return."""
        with files.explaining_full_disk(self.folder):
            self._manager.save(int(state.step), args=ocp.args.StandardSave(state), force=True)
            self._manager.wait_until_finished()

    def restore(self, like: TrainState) -> TrainState | None:
        """The last state saved, of the structure of `like`; None where there is none.

        Raises UserError if it cannot be read, or is of another structure.
        """
        step = self._manager.latest_step()
        if step is None:
            return None
        try:
            restored = self._manager.restore(step, args=ocp.args.StandardRestore(like))
        except Exception as error:  # Orbax raises many kinds for a torn or foreign checkpoint
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise UserError(
                f"{self.folder / str(step)} cannot be read ({reason}); "
                "remove it and train again in the same folder"
            ) from None
        return cast(TrainState, restored)

    def close(self) -> None:
        """Let go of the folder."""
        self._manager.close()

    def __enter__(self) -> "Checkpoints":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
