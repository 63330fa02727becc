"""The evaluation episodes of a run: `episodes.csv`, one row per episode."""

import csv
import io
import zlib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from pigbench.errors import UserError
from pigbench.evaluation.measures import MEASURES, Value
from pigbench.support import files
from pigbench.support.grouping import grouped


class Episode(NamedTuple):
    """One evaluation episode.

    `step` is the training step of the evaluated policy, `task` counts from 1, `episode` numbers the
    episodes of a task, `seed` is the evaluation's, `engine` the physics engine. `measures` has the
    known values of `MEASURES` by name: a diverged episode has no final distance, and a measure may
    have been added since.
    """

    step: int
    task: int
    task_name: str
    episode: int
    seed: int
    engine: str
    measures: Mapping[str, Value]


# The file's columns and their types: flags are 0 or 1, distances are given to a tenth of a
# millimetre, and unknown values are empty.
_WHICH = {name: kind for name, kind in Episode.__annotations__.items() if name != "measures"}
_CHECK = "check"  # a further column: the row's checksum
_FORMAT: dict[type, Callable[[Any], str]] = {
    int: str,
    str: str,
    bool: "{:d}".format,
    float: "{:.4f}".format,
}
_PARSE: dict[type, Callable[[str], Any]] = {
    int: int,
    str: str,
    bool: {"0": False, "1": True}.__getitem__,
    float: float,
}


def record(path: Path, episodes: Iterable[Episode]) -> None:
    """Add episodes to the file, atomically, replacing any of the same steps."""
    new = list(episodes)
    if not new:
        return  # a file without episodes is torn
    steps = {episode.step for episode in new}
    old = [episode for episode in read_any(path) if episode.step not in steps]
    _write(path, sorted(old + new, key=lambda one: (one.step, one.task, one.episode)))


def read(path: Path) -> list[Episode]:
    """The episodes in the file (at least one) by step, task and episode.

    The file may lack measures, except success. Raises UserError if it is torn, altered or invalid.
    """
    text = files.read_text(path)
    with files.explaining_torn(path, csv.Error):
        header, *rows = csv.reader(io.StringIO(text)) if text else [[]]
    *header, check = header or [""]
    columns, needed = _columns(), {*_WHICH, "success"}
    if check != _CHECK or not needed <= set(header) <= columns.keys():
        raise UserError(
            f"{path} is invalid: its columns are not {','.join(columns)} (for a measure of your "
            "own, add --plugin FILE)"
        )
    if not text.endswith("\n"):
        raise UserError(f"{path} is torn: its last row is cut off")
    if not rows:
        raise UserError(f"{path} is torn: it holds no episode")
    return [_parse(path, line, header, row) for line, row in enumerate(rows, start=2)]


def read_any(path: Path) -> list[Episode]:
    """The episodes in the file as by `read`, or none if there is no file yet."""
    return read(path) if path.exists() else []


def keep(path: Path, wanted: Callable[[int], bool]) -> None:
    """Remove the episodes of unwanted steps from the file, if it exists.

    If no episode is left, the file is removed too.
    """
    old = read_any(path)
    kept = [episode for episode in old if wanted(episode.step)]
    if not kept:
        path.unlink(missing_ok=True)
    elif kept != old:
        _write(path, kept)


def best_step(episodes: Iterable[Episode]) -> int:
    """The step with the highest success rate, the first if tied, as in tables of a single seed.

    Raises ValueError if there are no episodes.
    """
    by_step = grouped(episodes, lambda episode: episode.step)

    def rate(step: int) -> float:
        return sum(one.measures["success"] for one in by_step[step]) / len(by_step[step])

    return max(sorted(by_step), key=rate)


def _columns() -> dict[str, type]:
    """The types of the file's columns, by name."""
    if taken := MEASURES.keys() & {*_WHICH, _CHECK}:
        raise UserError(f"measure {min(taken)!r} has the name of another column: choose another")
    return _WHICH | {name: measure.kind for name, measure in MEASURES.items()}


def _write(path: Path, episodes: Iterable[Episode]) -> None:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*_columns(), _CHECK])
    writer.writerows([*row, _checksum(row)] for row in map(_row, episodes))
    files.write_text(path, text.getvalue())


def _row(episode: Episode) -> list[str]:
    values = {**episode._asdict(), **episode.measures}
    return [
        _FORMAT[kind](values[name]) if name in values else "" for name, kind in _columns().items()
    ]


def _checksum(row: list[str]) -> str:
    return f"{zlib.crc32(','.join(row).encode()):08x}"


def _parse(path: Path, line: int, header: list[str], row: list[str]) -> Episode:
    if row[-1:] != [_checksum(row[:-1])]:
        raise UserError(f"{path} is altered: the checksum of line {line} does not match")
    columns = _columns()
    try:
        values = {
            name: _PARSE[columns[name]](text)
            for name, text in zip(header, row[:-1], strict=True)
            if text or name in (*_WHICH, "success")
        }
        which = {name: values.pop(name) for name in _WHICH}
    except (ValueError, KeyError):
        raise UserError(f"{path} is torn: line {line} is not an episode") from None
    return Episode(**which, measures=values)
