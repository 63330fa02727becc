"""Progress of long work: a live line on a terminal, elsewhere a plain line every few seconds."""

import sys
import threading
import time
from collections.abc import Callable
from typing import TextIO

_LIVE_INTERVAL = 0.1
_PLAIN_INTERVAL = 5.0
_CLEAR_TO_END = "\x1b[K"
_SEPARATOR = ", "  # of a line's parts; none is within a number


class Progress:
    """Shows how far some work is, how fast it goes and how long it will still take.

    A context manager, for any threads. `done` is what an earlier run did: it counts for the
    percentage, but not for the rate. `clock` returns seconds.
    """

    def __init__(
        self,
        task: str,
        *,
        total: int,
        unit: str,
        done: int = 0,
        stream: TextIO | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._task = task
        self._total = total
        self._unit = unit
        self._done = self._done_before = done
        self._note = self._last_line = ""
        self._stream = sys.stderr if stream is None else stream
        self._live = self._stream.isatty()
        self._clock = clock
        self._begin = self._shown_at = clock()
        self._lock = threading.RLock()

    def advance(self, amount: int, note: str = "") -> None:
        """Count `amount` more units as done; `note` follows them on the line."""
        with self._lock:
            self._done += amount
            self._note = note
            interval = _LIVE_INTERVAL if self._live else _PLAIN_INTERVAL
            if self._clock() - self._shown_at >= interval:
                self._show(end="")

    def reach(self, done: int, note: str = "") -> None:
        """Like `advance`, given the total that is done."""
        with self._lock:
            self.advance(done - self._done, note)

    def __enter__(self) -> "Progress":
        self._show(end="")
        return self

    def __exit__(self, *_: object) -> None:
        self._show(end="\n")

    def _show(self, *, end: str) -> None:
        self._shown_at = self._clock()
        line = self._line()
        if self._live:
            self._stream.write(f"\r{line}{_CLEAR_TO_END}{end}")
        elif line != self._last_line:
            self._stream.write(f"{line}\n")
        self._last_line = line
        self._stream.flush()

    def _line(self) -> str:
        seconds = self._shown_at - self._begin
        work = self._done - self._done_before
        rate = work / seconds if seconds > 0 else 0.0
        parts = [f"{self._done:,} of {self._total:,} {self._unit}"]
        if rate > 0:
            left = (self._total - self._done) / rate
            parts.append(f"{rate:,.{0 if rate >= 10 else 1}f} {self._unit}/s")
            parts.append(f"{duration(left)} left" if left > 0 else f"took {duration(seconds)}")
        if self._note:
            parts.append(self._note)
        percent = 100 * self._done // self._total if self._total else 100
        return f"{self._task} {percent:3d} %  {_SEPARATOR.join(parts)}"


def how_far(line: str) -> str:
    """The first part of a shown line, which says how far the work is."""
    return line.split(_SEPARATOR)[0]


def duration(seconds: float) -> str:
    """Minutes and seconds, with hours if there are any."""
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}" if hours else f"{minutes}:{seconds:02d}"
