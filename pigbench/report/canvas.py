"""What all figures share: their look, a grid of panels, the legend and the file."""

import contextlib
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from jaxtyping import Shaped
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.container import Container
from matplotlib.figure import Figure
from matplotlib.ticker import (
    EngFormatter,
    LogLocator,
    MaxNLocator,
    NullFormatter,
)

from pigbench.errors import lookup
from pigbench.support import files

_LOOK: dict[Any, Any] = {
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "grid.alpha": 0.3,
    "hatch.linewidth": 0.7,
    "font.size": 9,
    "figure.dpi": 200,
    "legend.frameon": False,
    "legend.handlelength": 2.8,
    "lines.linewidth": 1.4,
    "lines.markersize": 3,
    "pdf.fonttype": 42,  # text stays text
    "svg.hashsalt": "pigbench",  # ids determined by the content
}
# No dates in files: same runs, same bytes.
_METADATA = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}
_LABELLED = 1, 2, 5  # multiples of powers of ten on a logarithmic axis; the first on a wide one
_WIDE = 1e3
# Inches.
_LEAST_WIDTH = 4.8
_LEGEND_LINE = 0.18
_LEGEND_MARGIN = 0.15
_LEGEND_HANDLE = 0.62
_CHARACTER = 0.063
_TITLE_CHARACTER = 0.085


@contextlib.contextmanager
def look(*, math: bool = False) -> Iterator[None]:
    """A block in which figures look the same, whatever the user's Matplotlib settings.

    Text between dollar signs is a formula if `math`; otherwise it may be part of a user's names.
    """
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_LOOK)
        mpl.rcParams["text.parse_math"] = math
        yield


def file_format(path: Path) -> str:
    """The format named by the extension of `path`. Raises UserError if it is unknown."""
    extension = path.suffix.removeprefix(".").lower()
    lookup("picture format", FigureCanvasAgg.get_supported_filetypes(), extension)
    return extension


def check_path(path: Path) -> None:
    """Raise UserError unless a figure can be written there, in the format of its extension."""
    file_format(path)
    files.require_file(path)


def save(figure: Figure, path: Path) -> None:
    """Write the figure in the format of its extension. Same figure, same bytes.

    Raises UserError like `check_path`.
    """
    extension = file_format(path)
    with files.replacing_file(path) as file:
        figure.savefig(file, format=extension, metadata=_METADATA.get(extension))


def grid(
    rows: int,
    columns: int,
    *,
    panel: tuple[float, float],
    legend: Sequence[str],
    share_y: bool = True,
) -> tuple[Figure, Shaped[np.ndarray, "{rows} {columns}"]]:
    """A figure and its panels of a size in inches, with room for a legend."""
    width = max(panel[0] * columns, _LEAST_WIDTH)
    lines = -(-len(legend) // _legend_columns(width, legend))
    figure = Figure(
        figsize=(width, panel[1] * rows + _LEGEND_LINE * lines + _LEGEND_MARGIN),
        layout="constrained",
    )
    return figure, figure.subplots(rows, columns, sharey=share_y, squeeze=False)


def add_remarks(figure: Figure, remarks: Sequence[str]) -> None:
    """Put remarks, if there are any, above the panels."""
    if remarks:
        text = wrapped("; ".join(remarks), figure.get_figwidth())
        lines = 1 + text.count("\n")
        figure.set_figheight(figure.get_figheight() + _LEGEND_LINE * lines)
        figure.suptitle(text, fontsize="medium")


def wrapped(title: str, width: float) -> str:
    """The title in lines of at most that width, in inches."""
    return textwrap.fill(title, max(1, int(width / _TITLE_CHARACTER)))


def add_legend(figure: Figure, handles: Mapping[str, Artist | Container]) -> None:
    """Add a legend below the panels."""
    figure.legend(
        list(handles.values()),  # pyright: ignore[reportArgumentType]  bars too
        list(handles),
        loc="outside lower center",
        ncols=_legend_columns(figure.get_figwidth(), list(handles)),
    )


def log_axis(panel: Axes, name: Literal["x", "y"]) -> None:
    """Make the axis of what is drawn logarithmic, with plain numbers as labels.

    Matplotlib's own are formulas.
    """
    panel.set(**{f"{name}scale": "log"})
    axis = panel.xaxis if name == "x" else panel.yaxis
    low, high = panel.get_xlim() if name == "x" else panel.get_ylim()
    wide = high / low > _WIDE
    axis.set_major_locator(LogLocator(subs=_LABELLED[:1] if wide else _LABELLED))
    axis.set_major_formatter(_number)
    axis.set_minor_formatter(NullFormatter())


def _number(value: float, _: object) -> str:
    return EngFormatter(sep="")(value) if value >= 1 else f"{value:g}"


def step_axis(panel: Axes) -> None:
    """Make the horizontal axis one of training steps."""
    panel.set_xlabel("training steps")
    panel.xaxis.set_major_formatter(EngFormatter(sep=""))
    panel.xaxis.set_major_locator(MaxNLocator(5))


def _legend_columns(width: float, names: Sequence[str]) -> int:
    longest = max(map(len, names), default=0)
    return max(1, min(len(names), int(width / (_LEGEND_HANDLE + _CHARACTER * longest))))
