"""`pigbench bench device`: the performance of this machine's accelerator, within minutes."""

import dataclasses
import json
import os
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jax

from pigbench.bench import budget, device, device_report
from pigbench.bench.budget import RATE, Result, Row
from pigbench.bench.device import Sizes
from pigbench.errors import UserError
from pigbench.support import files
from pigbench.support.lock import only_writer


@dataclasses.dataclass(frozen=True)
class Device:
    """Measure this machine's accelerator: control steps, training, parity with MuJoCo in C, data
    generation, evaluation; the most informative first, until the time is up.

    Each result is saved at once: run the same command again to measure what there was no time for.
    If a row fails, the reason is saved; a new folder starts afresh. On a GPU, JAX allocates memory
    as it needs it, which leaves room for Warp (with XLA_PYTHON_CLIENT_PREALLOCATE=true, JAX takes
    its share first).
    """

    out: Path
    """Folder for device.json, device.md and device.png."""
    minutes: float = 8.0
    """Time limit in minutes; no measurement starts that would not end within it."""
    sizes: Sizes = dataclasses.field(default_factory=Sizes)
    """What to measure, and in what sizes."""

    def run(self) -> None:
        """Measure, print each row as it is done, and write tables and a plot."""
        if self.minutes <= 0:
            raise UserError(f"minutes is {self.minutes:g}: it must be more than 0")
        deadline = time.monotonic() + 60 * self.minutes
        os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")  # read when JAX starts
        jax.config.update("jax_enable_compilation_cache", False)  # compilation is timed too
        with only_writer(self.out):
            rows = device.rows(self.sizes)
            origin = {"sizes": dataclasses.asdict(self.sizes)} | device.machine()
            results = _earlier(self.out / "device.json", origin)

            def report(row: Row, result: Result) -> None:
                print(budget.line(row, result), flush=True)
                if row.labels["what"] == "steps" and RATE in result:
                    device_report.draw(_entries(rows, results), self.out / "device.png")

            budget.run(
                rows,
                results,
                deadline=deadline,
                keep=lambda: _keep(self.out, origin, _entries(rows, results)),
                alive=device.alive,
                report=report,
            )
        print(f"device.json, device.md and device.png are in {self.out}")


def _earlier(path: Path, origin: dict[str, Any]) -> dict[str, Result]:
    """The results of an earlier run of the same code on the same machine."""
    if not path.exists():
        return {}
    content = files.read_json(path)
    rows = content.pop("rows")
    same = content == json.loads(json.dumps(origin))  # JSON has no tuples
    return {row["row"]: row for row in rows} if same else {}


def _entries(rows: Sequence[Row], results: dict[str, Result]) -> list[dict[str, Any]]:
    return [
        {"row": row.name, **row.labels, **results[row.name]} for row in rows if row.name in results
    ]


def _keep(folder: Path, origin: dict[str, Any], entries: list[dict[str, Any]]) -> None:
    files.write_json(folder / "device.json", origin | {"rows": entries})
    files.write_text(folder / "device.md", device_report.tables(origin, entries))
