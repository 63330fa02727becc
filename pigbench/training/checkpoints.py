"""Training states on disk, by Orbax: written whole or not at all; the last two at least are kept.

Two, because runs that are trained together go on from a step that all of them have saved.
"""

import contextlib
import dataclasses
import hashlib
import logging
from collections.abc import Callable, Collection, Iterator, Sequence
from pathlib import Path
from typing import Any, cast

import jax
import numpy as np
import orbax.checkpoint as ocp
from orbax.checkpoint import checkpoint_managers

from pigbench.agents import TrainState
from pigbench.errors import UserError
from pigbench.support import files

_DIGEST = "sha256"

Kept = Callable[[Sequence[int]], Collection[int]]
"""Of the steps that have a checkpoint, in order, those that are to have it still."""


def last_two(steps: Sequence[int]) -> Sequence[int]:
    """What going on needs."""
    return steps[-2:]


class Checkpoints:
    """The checkpoints of a run's folder; after each `save`, those of `kept` are left. A context
    manager.

    Where `read_only`, nothing is made or tidied there: another process may be training.
    """

    def __init__(self, folder: Path, *, kept: Kept = last_two, read_only: bool = False) -> None:
        self.folder = folder
        with files.explaining_full_disk(folder), _without_log():
            options = ocp.CheckpointManagerOptions(
                preservation_policy=_Preservation(kept),
                enable_async_checkpointing=False,
                read_only=read_only,
            )
            self._manager = ocp.CheckpointManager(folder.absolute(), options=options)

    def steps(self) -> list[int]:
        """The training steps of the states that are kept."""
        return list(self._manager.all_steps())

    def save(self, state: TrainState) -> None:
        """Keep `state`, complete on return; a state of its step that is there already is the same.

        Updates are deterministic, which makes it so.
        """
        step = int(state.step)
        if step in self.steps():
            return
        size = sum(leaf.nbytes for leaf in jax.tree.leaves(state))
        files.require_room(self.folder / str(step), size)
        with files.explaining_full_disk(self.folder), _without_log():
            self._manager.save(
                step,
                args=ocp.args.StandardSave(state),
                custom_metadata={_DIGEST: _digest(state)},
                force=True,
            )
            self._manager.wait_until_finished()

    def drop(self, unwanted: Callable[[int], bool]) -> None:
        """Remove the states of such steps."""
        for step in filter(unwanted, self.steps()):
            with _without_log():
                self._manager.delete(step)

    def restore(self, like: TrainState, step: int) -> TrainState:
        """The state of that step, of the structure of `like`.

        Raises UserError if it cannot be read, or is of another structure.
        """
        try:
            with _without_log():
                restored = cast(
                    TrainState,
                    self._manager.restore(step, args=ocp.args.StandardRestore(like)),
                )
                kept = self._manager.metadata(step).custom_metadata or {}
        except Exception as error:  # Orbax raises many kinds for a torn or foreign checkpoint
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise UserError(
                f"{self.folder / str(step)} cannot be read ({reason}); "
                "remove it and train again in the same folder"
            ) from None
        if kept.get(_DIGEST) not in (None, _digest(restored)):  # those from before have none
            raise UserError(
                f"{self.folder / str(step)} is altered: its numbers have not the checksum that it "
                "bears; remove it and train again in the same folder"
            )
        return restored

    def close(self) -> None:
        """Let go of the folder."""
        self._manager.close()

    def __enter__(self) -> "Checkpoints":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


@dataclasses.dataclass(frozen=True)
class _Preservation(checkpoint_managers.PreservationPolicy):
    """`Kept`, as Orbax asks for it."""

    kept: Kept

    def should_preserve(self, checkpoints: Sequence[Any], *, context: Any) -> Sequence[bool]:
        steps = [checkpoint.step for checkpoint in checkpoints]
        kept = self.kept(steps)
        return [step in kept for step in steps]


def _digest(state: TrainState) -> str:
    """The SHA-256 of all numbers of a state, in hexadecimal."""
    digest = hashlib.sha256()
    for leaf in jax.device_get(jax.tree.leaves(state)):
        digest.update(np.ascontiguousarray(leaf).data)
    return digest.hexdigest()


@contextlib.contextmanager
def _without_log() -> Iterator[None]:
    """Orbax logs the tracebacks of what it raises too, those of its threads included."""
    logger = logging.getLogger("absl")
    before, logger.disabled = logger.disabled, True
    try:
        yield
    finally:
        logger.disabled = before


def common_step(several: Sequence[Checkpoints]) -> int | None:
    """The last step that each of them keeps; None if there is none."""
    return max(set.intersection(*(set(one.steps()) for one in several)), default=None)
