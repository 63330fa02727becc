"""The logs of a suite's jobs, one file each."""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from pigbench.support.progress import how_far

_TOLD = 3  # lines of a failed job's log, before the one with its exit status


def log_path(out: Path, job: str) -> Path:
    """The file with the output of a job of the suite in `out`."""
    return out / "logs" / f"{job}.log"


def last_lines(log: Path, count: int) -> Sequence[str]:
    """The last lines of a log that are not blank; none if there is no log."""
    if not log.exists():
        return []
    text = log.read_text(encoding="utf-8", errors="replace")
    return [line for line in re.split(r"[\r\n]+", text) if line.strip()][-count:]


def last_said(out: Path, running: Sequence[str]) -> str:
    """What each running job of the suite in `out` said last, in one line."""
    lines = (last_lines(log_path(out, name), 1) for name in running)
    said = (how_far(line[0]) if line else "starting" for line in lines)
    return "; ".join(f"{name}: {text}" for name, text in zip(running, said, strict=True))


def explain(failed: Iterable[tuple[str, int]], out: Path) -> str:
    """The names, exit statuses and last words of jobs that failed."""
    lines = []
    for name, code in failed:
        log = log_path(out, name)
        lines.append(f"\n{name} failed with exit status {code}; the end of {log}:")
        lines += [f"  {line}" for line in last_lines(log, _TOLD + 1)[:-1]]
    return "\n".join(lines)
