"""The log of training metrics in JSON lines. Trackers display them."""

import itertools
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pigbench.support import files

FILE_NAME = "metrics.jsonl"


class MetricsLog:
    """Appends to the metrics of a run, from `step` on: what was logged beyond it is dropped.

    Each line is a JSON object with `step` and the metrics (null if not finite), passed to the
    operating system at once. A context manager.
    """

    def __init__(self, folder: Path, *, step: int) -> None:
        path = folder / FILE_NAME
        _drop_beyond(path, step)
        self._lines = open(path, "a", encoding="utf-8")  # noqa: SIM115

    def write(self, step: int, metrics: Mapping[str, float]) -> None:
        """Log numbers by name."""
        finite = {name: x if math.isfinite(x) else None for name, x in metrics.items()}
        with files.explaining_full_disk(Path(self._lines.name)):
            self._lines.write(json.dumps({"step": step, **finite}) + "\n")
            self._lines.flush()

    def close(self) -> None:
        """Close the file."""
        self._lines.close()

    def __enter__(self) -> "MetricsLog":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def read(folder: Path) -> list[dict[str, Any]]:
    """The logged lines of the run in `folder`, in order, up to a line torn by a crash."""
    lines = files.read_text(folder / FILE_NAME).splitlines()
    return [json.loads(line) for line in itertools.takewhile(_is_whole, lines)]


def _drop_beyond(path: Path, step: int) -> None:
    if path.exists():
        kept = [line for line in read(path.parent) if line["step"] <= step]
        files.write_text(path, "".join(json.dumps(line) + "\n" for line in kept))


def _is_whole(line: str) -> bool:
    try:
        return isinstance(json.loads(line), dict)
    except json.JSONDecodeError:
        return False
