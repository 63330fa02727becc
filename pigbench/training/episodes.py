"""The evaluation episodes of a run: `episodes.csv`, one row an episode."""

import csv
import io
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

from pigbench.errors import UserError
from pigbench.support import files


class Episode(NamedTuple):
    """One evaluation episode. The fields are the columns of the file; flags are 0 or 1 there.

    `step` is the training step of the evaluated policy, `task` counts from 1, `episode` tells the
    episodes of a task apart, `seed` is the evaluation's, and `length` is in control steps.
    """

    step: int
    task: int
    task_name: str
    episode: int
    seed: int
    success: bool
    length: int
    diverged: bool


_FORMAT: dict[type, Callable[[Any], Any]] = {int: int, str: str, bool: int}
_PARSE: dict[type, Callable[[str], Any]] = {
    int: int,
    str: str,
    bool: {"0": False, "1": True}.__getitem__,
}


def record(path: Path, episodes: Iterable[Episode]) -> None:
    """Adds episodes to the file, atomically, instead of any it has of the same steps."""
    new = list(episodes)
    steps = {episode.step for episode in new}
    old = [episode for episode in read(path) if episode.step not in steps] if path.exists() else []
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(Episode._fields)
    writer.writerows(_convert(_FORMAT, episode) for episode in sorted(old + new))
    files.write_text(path, text.getvalue())


def read(path: Path) -> list[Episode]:
    """The episodes in the file, by step, task and episode. Raises UserError when it is torn."""
    text = files.read_text(path)
    header, *rows = csv.reader(io.StringIO(text)) if text else [[]]
    if tuple(header) != Episode._fields:
        raise UserError(f"{path} is torn: its columns are not {','.join(Episode._fields)}")
    if not text.endswith("\n"):
        raise UserError(f"{path} is torn: its last row is cut off")
    return [_parse(path, number, row) for number, row in enumerate(rows, start=2)]


def _parse(path: Path, line: int, row: list[str]) -> Episode:
    try:
        return Episode(*_convert(_PARSE, row))
    except (ValueError, KeyError):
        raise UserError(f"{path} is torn: line {line} is no episode") from None


def _convert(converters: dict[type, Callable[[Any], Any]], row: Iterable[Any]) -> list[Any]:
    columns = Episode.__annotations__.values()
    return [converters[column](value) for column, value in zip(columns, row, strict=True)]
