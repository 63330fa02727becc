"""Training states on disk, by Orbax: written completely or not at all; at least two are kept.

Two, because runs that are trained together resume from a step that all of them have saved.
"""

import contextlib
import dataclasses
import hashlib
import logging
import textwrap
from collections.abc import Callable, Collection, Iterator, Sequence
from pathlib import Path
from typing import Any, cast

import jax
import numpy as np
import orbax.checkpoint as ocp
import tensorstore
from orbax.checkpoint import checkpoint_managers

from pigbench.agents import TrainState
from pigbench.errors import UserError
from pigbench.support import files

_DIGEST = "sha256"

Kept = Callable[[Sequence[int]], Collection[int]]
"""Selects, from the steps with checkpoints in order, those whose checkpoints are kept."""


def last_two(steps: Sequence[int]) -> Sequence[int]:
    """The steps that are needed to resume."""
    return steps[-2:]


class Checkpoints:
    """The checkpoints in a run's folder; each `save` leaves only those selected by `kept`.

    A context manager. If `read_only`, nothing is made or removed: another process may be training.
    Raises UserError if a checkpoint's own record, which Orbax reads at once, is altered.
    """

    def __init__(self, folder: Path, *, kept: Kept = last_two, read_only: bool = False) -> None:
        self.folder = folder
        with files.explaining_full_disk(folder), _without_log():
            options = ocp.CheckpointManagerOptions(
                preservation_policy=_Preservation(kept),
                enable_async_checkpointing=False,
                read_only=read_only,
            )
            try:
                self._manager = ocp.CheckpointManager(folder.absolute(), options=options)
            except Exception as error:  # Orbax raises many types, and names no folder
                altered = _altered_record(folder)
                if altered is None:
                    raise
                raise _unreadable(altered, error) from None

    def steps(self) -> list[int]:
        """The training steps whose states are kept, in order."""
        return sorted(self._manager.all_steps())

    def save(self, state: TrainState) -> None:
        """Save `state`, complete on return, unless its step is already saved.

        Updates are deterministic, so an existing state of the same step is equal.
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
        """Remove the states of unwanted steps."""
        for step in filter(unwanted, self.steps()):
            with _without_log():
                self._manager.delete(step)

    def restore(self, like: TrainState, step: int) -> TrainState:
        """The state of that step, with the structure of `like`, whose leaves may be mere shapes.

        Raises UserError if it cannot be read, or if its structure differs.
        """
        device = jax.sharding.SingleDeviceSharding(jax.local_devices()[0])
        shapes = jax.tree.map(
            lambda leaf: jax.ShapeDtypeStruct(leaf.shape, leaf.dtype, sharding=device), like
        )
        try:
            _read_through(self.folder / str(step))
            with _without_log():
                restored = cast(
                    TrainState,
                    self._manager.restore(step, args=ocp.args.StandardRestore(shapes)),
                )
                kept = self._manager.metadata(step).custom_metadata or {}
        except Exception as error:  # Orbax raises many types for a damaged or foreign checkpoint
            raise _unreadable(self.folder / str(step), error) from None
        if kept.get(_DIGEST) != _digest(restored):
            raise UserError(
                f"{self.folder / str(step)} is altered: its checksum does not match; "
                "remove it and train again in the same folder"
            )
        return restored

    def close(self) -> None:
        """Release the folder."""
        self._manager.close()

    def __enter__(self) -> "Checkpoints":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


@dataclasses.dataclass(frozen=True)
class _Preservation(checkpoint_managers.PreservationPolicy):
    """`Kept` as an Orbax policy."""

    kept: Kept

    def should_preserve(self, checkpoints: Sequence[Any], *, context: Any) -> Sequence[bool]:
        steps = [checkpoint.step for checkpoint in checkpoints]
        kept = self.kept(sorted(steps))  # they come in the order of saving
        return [step in kept for step in steps]


def _altered_record(folder: Path) -> Path | None:
    """The first checkpoint in `folder` whose record of its own times cannot be read."""
    for step in ocp.path.step.standard_name_format().find_all(folder.absolute()):
        try:
            _ = step.commit_timestamp
        except Exception:  # ValueError, TypeError, OverflowError, ...: by what a byte became
            return folder / str(step.step)
    return None


def _read_through(checkpoint: Path) -> None:
    """Read all arrays, so that a damaged one raises here.

    In Orbax it would raise beside reads that go on: their errors are printed from other threads.
    """
    base = {"driver": "ocdbt", "base": f"file://{checkpoint.absolute()}/default/"}
    entries = tensorstore.KvStore.open(base).result().list().result()
    names = {entry.decode().rpartition("/")[0] for entry in entries}
    arrays = [
        tensorstore.open({"driver": "zarr", "kvstore": {**base, "path": f"{name}/"}}, open=True)
        for name in names
    ]
    for read in [array.result().read() for array in arrays]:
        read.result()


def _unreadable(checkpoint: Path, error: Exception) -> UserError:
    reason = textwrap.shorten(str(error), 200) or type(error).__name__
    return UserError(
        f"{checkpoint} cannot be read ({reason}); remove it and train again in the same folder"
    )


def _digest(state: TrainState) -> str:
    """The SHA-256 of all numbers of a state, in hexadecimal."""
    digest = hashlib.sha256()
    for leaf in jax.device_get(jax.tree.leaves(state)):
        digest.update(np.ascontiguousarray(leaf).data)
    return digest.hexdigest()


@contextlib.contextmanager
def _without_log() -> Iterator[None]:
    """Silence Orbax, which also logs the tracebacks of what it raises, in its threads too."""
    logger = logging.getLogger("absl")
    before, logger.disabled = logger.disabled, True
    try:
        yield
    finally:
        logger.disabled = before
