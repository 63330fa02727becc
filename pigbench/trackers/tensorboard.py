"""TensorBoard events, in the run's folder `tensorboard`. TensorBoard shows films only as GIFs.

The library is imported when it is used: this is the default, whose name every `--help` shows.
"""

from collections.abc import Mapping
from pathlib import Path

from pigbench.runs.run import Run
from pigbench.support import files, pictures
from pigbench.trackers.registry import register
from pigbench.trackers.tracker import Tracker

FOLDER = "tensorboard"


class TensorBoard(Tracker):
    """TensorBoard events. Those beyond the step from which training resumes are hidden."""

    def __init__(self, run: Run, *, step: int) -> None:
        from tensorboardX import SummaryWriter

        super().__init__(run, step=step)
        self._folder = run.path / FOLDER
        self._events = SummaryWriter(str(self._folder), purge_step=step + 1)

    def scalars(self, step: int, values: Mapping[str, float]) -> None:
        """Write the numbers at once."""
        with files.explaining_full_disk(self._folder):
            for name, value in values.items():
                self._events.add_scalar(name, value, step)
            self._events.flush()

    def film(self, step: int, name: str, path: Path) -> None:
        """Write the film as a smaller GIF."""
        from tensorboardX.proto.summary_pb2 import (
            Summary,  # pyright: ignore[reportAttributeAccessIssue]
        )

        gif, height, width = pictures.gif_of_mp4(path)
        image = Summary.Image(height=height, width=width, colorspace=3, encoded_image_string=gif)
        summary = Summary(value=[Summary.Value(tag=name, image=image)])
        with files.explaining_full_disk(self._folder):
            assert self._events.file_writer is not None
            self._events.file_writer.add_summary(summary, step)
            self._events.flush()

    def close(self) -> None:
        """Close the file."""
        self._events.close()


register("tensorboard", TensorBoard)
