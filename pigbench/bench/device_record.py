"""What has been measured of an accelerator, kept in a folder as device.json and device.md."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pigbench.bench import device_report
from pigbench.bench.budget import Row, RowResult
from pigbench.bench.device_report import MeasuredRow
from pigbench.support import files

_FILE = "device.json"


def earlier(folder: Path, origin: Mapping[str, Any]) -> dict[str, RowResult]:
    """The results of an earlier run of the same code on the same machine, by row."""
    path = folder / _FILE
    if not path.exists():
        return {}
    content = files.read_json(path)
    rows = content.pop("rows")
    same = content == json.loads(json.dumps(origin))  # JSON has no tuples
    return {row["row"]: row for row in rows} if same else {}


def entries(rows: Sequence[Row], results: Mapping[str, RowResult]) -> list[MeasuredRow]:
    """The rows that have a result, in order, each with it."""
    return [
        {"row": row.name, **row.labels, **results[row.name]} for row in rows if row.name in results
    ]


def keep(folder: Path, origin: Mapping[str, Any], entries: Sequence[MeasuredRow]) -> None:
    """Write the files."""
    files.write_json(folder / _FILE, {**origin, "rows": entries})
    files.write_text(folder / "device.md", device_report.tables(origin, entries))
