"""The progress of a suite, determined from its files alone."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from pigbench.data import manifest
from pigbench.errors import UserError
from pigbench.evaluation import episodes
from pigbench.report.stats import success_rate
from pigbench.runs.metrics import FILE_NAME as METRICS_FILE
from pigbench.runs.run import CHECKPOINTS, EPISODES_FILE, read_run
from pigbench.suite import runner
from pigbench.suite.logs import last_lines, log_path
from pigbench.suite.spec import Suite, SuiteCell
from pigbench.support.lock import is_held

DONE, RUNNING, FAILED, CUT_OFF, WAITING = "done", "running", "failed", "cut off", "waiting"


class Status(NamedTuple):
    """A cell's state, the updates it has done, and its last success rate in percent, if any."""

    cell: SuiteCell
    state: str
    steps: int
    success: float | None


def status(suite: Suite, out: Path) -> list[Status]:
    """The status of every cell of the suite in the folder `out`."""
    return [_status(cell, out) for cell in suite.cells()]


def update(known: Sequence[Status], out: Path) -> list[Status]:
    """The current status of the same cells; those that were done are not read again."""
    return [one if one.state == DONE else _status(one.cell, out) for one in known]


def untried(suite: Suite, cell: SuiteCell, out: Path) -> list[float]:
    """The suite's noise levels, in millimetres, that lack episodes of the cell's last step."""
    run = read_run(out / cell.name)

    def is_tried(level: float) -> bool:
        try:
            rows = episodes.read(run.noise_path(level))
        except UserError:  # missing, or torn, which the command that writes it reports
            return False
        return any(row.step == cell.environment.steps for row in rows)

    return [level for level in suite.evaluation.noise if not is_tried(level)]


def is_complete(folder: Path) -> bool:
    """Whether the folder contains a complete data set."""
    try:
        return manifest.remaining(folder) is None
    except UserError:
        return False


def table(cells: Sequence[Status]) -> list[tuple[str, ...]]:
    """One line per cell, with a header."""
    lines = [
        (
            cell.name,
            state,
            f"{steps:,} of {cell.environment.steps:,}",
            "" if success is None else f"{success:.1f}",
        )
        for cell, state, steps, success in cells
    ]
    return [("cell", "state", "updates", "success (%)"), *lines]


def _status(cell: SuiteCell, out: Path) -> Status:
    folder = out / cell.name
    evaluated = _last_evaluation(folder)
    step, success = evaluated or (0, None)
    if step == cell.environment.steps and (folder / CHECKPOINTS / str(step)).exists():
        return Status(cell, DONE, step, success)
    return Status(cell, _unfinished(folder, log_path(out, cell.name)), _last_step(folder), success)


def _unfinished(folder: Path, log: Path) -> str:
    if is_held(folder):
        return RUNNING
    last = last_lines(log, 1)
    if last and last[0].startswith(runner.FAILURE):
        return FAILED
    return CUT_OFF if folder.exists() else WAITING


def _last_evaluation(folder: Path) -> tuple[int, float] | None:
    try:
        rows = episodes.read(folder / EPISODES_FILE)
    except UserError:
        return None
    step = max(row.step for row in rows)
    return step, success_rate([row for row in rows if row.step == step])


def _last_step(folder: Path) -> int:
    lines = last_lines(folder / METRICS_FILE, 1)
    try:
        return int(json.loads(lines[0])["step"]) if lines else 0
    except json.JSONDecodeError:  # just being written
        return 0
