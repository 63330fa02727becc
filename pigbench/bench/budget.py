"""Measurements within a time limit: rows, the most informative first, each saved at once."""

import gc
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

RowResult = Mapping[str, Any]
"""The measurements, or the reason for having none, under `FAILED` or `SKIPPED`."""

FAILED, SKIPPED = "failed", "skipped"
RATE, FIRST, TOOK = "rate", "first_s", "took_s"
NO_TIME = "no time left"
LOST = "the device no longer answers; run the same command again to go on"
KILLED = "the process ended while it ran"

_LEAST_GAIN = 1.05  # factor in the rate from one size of a series to the next
_REASON = 300  # characters


@dataclass(frozen=True)
class Row:
    """One thing to measure.

    Attributes:
        kind: type of the row; rows of one kind take about equally long to compile.
        series: name shared by rows that differ only in size. A series ends with the first row that
            fails, or whose rate is hardly higher than that of the row before.
        size: how much is done at once.
        labels: what distinguishes the row from others, ready for JSON.
        measure: takes the measurement; `FIRST` in its result is the seconds that do not grow with
            the size.
        seconds: estimated duration, used until a row of its kind has been measured.
    """

    kind: str
    series: str
    size: int
    labels: Mapping[str, Any]
    measure: Callable[[], RowResult]
    seconds: float

    @property
    def name(self) -> str:
        """Series and size."""
        return f"{self.series}, {self.size:,}"


def run(
    rows: Sequence[Row],
    results: dict[str, RowResult],
    *,
    deadline: float,
    keep: Callable[[], object],
    alive: Callable[[], bool] = lambda: True,
    report: Callable[[Row, RowResult], object] = lambda *_: None,
    clock: Callable[[], float] = time.monotonic,
) -> None:
    """Measure in order the rows that have no entry in `results`, by name, and add theirs.

    A row that is expected to end after `deadline` is skipped; for a row that fails, the reason is
    recorded, and the others go on as long as the device is still `alive`. `keep` is called whenever
    `results` change; before a row starts, it is recorded as having killed the process. `report` is
    called with each row and its result.
    """
    lost = False
    for row in rows:
        if row.name in results and SKIPPED not in results[row.name]:
            continue
        begin = clock()
        reason = LOST if lost else _reason_to_skip(row, rows, results, deadline - begin)
        if reason:
            results[row.name] = {SKIPPED: reason}
        else:
            results[row.name] = {FAILED: KILLED}
            keep()
            try:
                outcome = dict(row.measure())
            except Exception as error:
                outcome = {FAILED: _one_line(error)}
            except BaseException:  # interrupted by the user: to be measured another time
                del results[row.name]
                keep()
                raise
            results[row.name] = outcome | {TOOK: clock() - begin}
            gc.collect()  # the row's arrays leave the device
            lost = FAILED in outcome and not alive()
        keep()
        report(row, results[row.name])


def line(row: Row, result: RowResult) -> str:
    """A row and its result as text."""
    shown = (
        f"{name} {value:,.4g}" if isinstance(value, float) else f"{name} {value}"
        for name, value in result.items()
        if value is not None
    )
    return f"{row.name}: {', '.join(shown)}"


def _reason_to_skip(
    row: Row, rows: Sequence[Row], results: Mapping[str, RowResult], left: float
) -> str | None:
    before = [
        results[other.name]
        for other in rows
        if other.series == row.series and other.size < row.size and other.name in results
    ]
    if any(FAILED in result for result in before):
        return "a smaller one failed"
    rates = [result[RATE] for result in before if RATE in result]
    if len(rates) > 1 and rates[-1] < _LEAST_GAIN * rates[-2]:
        return "the rate rises no more"
    if any(SKIPPED in result for result in before):
        return "a smaller one was skipped"
    return NO_TIME if _estimate(row, rows, results) > left else None


def _estimate(row: Row, rows: Sequence[Row], results: Mapping[str, RowResult]) -> float:
    """Expected seconds: those of the last row of its kind, with the work scaled by size."""
    alike = [
        (other.size, results[other.name])
        for other in rows
        if other.kind == row.kind and RATE in results.get(other.name, {})
    ]
    if not alike:
        return row.seconds
    size, result = alike[-1]
    fixed = min(result.get(FIRST, 0.0), result[TOOK])
    return fixed + (result[TOOK] - fixed) * max(1.0, row.size / size)


def _one_line(error: Exception) -> str:
    words = " ".join(str(error).split())
    text = f"{type(error).__name__}: {words}"
    return text if len(text) <= _REASON else f"{text[:_REASON]}..."
