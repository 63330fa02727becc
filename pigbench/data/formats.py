"""The formats in which data sets are written for others and read from them, by name."""

import importlib
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from pigbench.data.dataset import Dataset
from pigbench.errors import UserError, lookup


class Format(NamedTuple):
    """A format: its module, whether that has `write` and `read`, and the options of `write`.

    Modules are imported only when needed: inspecting a data set takes no simulator.
    """

    module: str
    options: tuple[str, ...] = ()
    writes: bool = True
    reads: bool = False


FORMATS = {
    "ogbench": Format("pigbench.data.ogbench", ("rows_per_file", "goals"), reads=True),
    "minari": Format("pigbench.data.minari"),
    "lerobot": Format("pigbench.data.lerobot"),
    "log": Format("pigbench.data.logs", writes=False, reads=True),
}


def writer(name: str, options: Mapping[str, Any]) -> Callable[[Dataset, Path], Sequence[Path]]:
    """The format's `write`, with these options; it returns the paths that it has written.

    Raises UserError if data sets are not written in that format, or not with such an option.
    """
    form = lookup("format", {key: one for key, one in FORMATS.items() if one.writes}, name)
    for option, value in options.items():
        if option not in form.options:
            raise UserError(f"{option} is {value!r}: format {name!r} has no such option")
    return partial(importlib.import_module(form.module).write, **options)


def reader(name: str) -> Callable[..., None]:
    """The format's `read`. Raises UserError if data sets are not read from that format."""
    form = lookup("format", {key: one for key, one in FORMATS.items() if one.reads}, name)
    return importlib.import_module(form.module).read
