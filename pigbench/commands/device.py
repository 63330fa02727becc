"""`pigbench bench device`: the performance of this machine's accelerator, within minutes."""

import dataclasses
import os
import time
from pathlib import Path

from pigbench.bench import budget, device_record, device_report
from pigbench.bench.budget import RATE, Row, RowResult
from pigbench.bench.sizes import Sizes
from pigbench.errors import require
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
        import jax

        from pigbench.bench import device

        require(self, lambda x: x > 0, "more than 0", "minutes")
        deadline = time.monotonic() + 60 * self.minutes
        os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")  # read when JAX starts
        jax.config.update("jax_enable_compilation_cache", False)  # compilation is timed too
        with only_writer(self.out):
            rows = device.rows(self.sizes)
            origin = {"sizes": dataclasses.asdict(self.sizes)} | device.machine()
            results = device_record.earlier(self.out, origin)

            def report(row: Row, result: RowResult) -> None:
                print(budget.line(row, result), flush=True)
                if row.labels["what"] == "steps" and RATE in result:
                    entries = device_record.entries(rows, results)
                    device_report.draw(entries, self.out / "device.png")

            budget.run(
                rows,
                results,
                deadline=deadline,
                keep=lambda: device_record.keep(
                    self.out, origin, device_record.entries(rows, results)
                ),
                alive=device.alive,
                report=report,
            )
        print(f"device.json, device.md and device.png are in {self.out}")
