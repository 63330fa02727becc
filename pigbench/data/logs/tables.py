"""Reading a log's table from a file: CSV, or Parquet if pyarrow is installed."""

import csv
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pigbench.data.logs.columns import LogTable
from pigbench.errors import UserError
from pigbench.support import files
from pigbench.support.extras import required
from pigbench.support.grouping import repeated


def read(path: Path) -> LogTable:
    """The columns of a file with one of the suffixes in `READERS`. UserError if it is invalid."""
    if not path.is_file():
        raise UserError(f"{path} does not exist")
    if path.suffix not in READERS:
        raise UserError(f"{path} does not end in {' or '.join(READERS)}, as logs do")
    return READERS[path.suffix](path)


def _read_csv(path: Path) -> LogTable:
    with files.explaining_torn(path, csv.Error):
        header, *lines = list(csv.reader(files.read_text(path).splitlines())) or [[]]
    names = [name.strip() for name in header]
    twice = repeated(names)
    if twice is not None:
        raise UserError(f"{path} has two columns named {twice!r}")
    for row, line in enumerate(lines):
        if len(line) != len(names):
            raise UserError(f"{path} has {len(line)} cells in row {row}, under {len(names)} names")
    return {
        name: np.array([_number(line[place]) for line in lines]) for place, name in enumerate(names)
    }


def _number(cell: str) -> float:
    """The cell's number; NaN for other cells, which no needed column may contain."""
    try:
        return float(cell)
    except ValueError:
        return math.nan


def _read_parquet(path: Path) -> LogTable:
    table = parquet(path)
    return {
        name: table.column(name).to_numpy().astype(float)
        for name in table.column_names
        if _is_number(table.schema.field(name).type)
    }


def parquet(path: Path) -> Any:
    """A file as a pyarrow table. Raises UserError if it is torn or pyarrow is not installed."""
    pa, pq = required("pyarrow", "pyarrow.parquet", extra="share")
    with files.explaining_torn(path, pa.ArrowException, OSError):
        return pq.read_table(path)


def _is_number(kind: Any) -> bool:
    (types,) = required("pyarrow.types", extra="share")
    return types.is_floating(kind) or types.is_integer(kind) or types.is_boolean(kind)


READERS: Mapping[str, Callable[[Path], LogTable]] = {".csv": _read_csv, ".parquet": _read_parquet}
