"""Learning curves: success over training steps."""

import zlib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import EngFormatter

from pigbench.errors import lookup
from pigbench.report import stats
from pigbench.report.stats import Estimate, Result
from pigbench.report.tables import ordered
from pigbench.support import files

# Okabe and Ito's palette, which the colour-blind can tell apart (jfly.uni-koeln.de/color).
BLACK = "#000000"
ORANGE = "#E69F00"
SKY_BLUE = "#56B4E9"
GREEN = "#009E73"
YELLOW = "#F0E442"
BLUE = "#0072B2"
VERMILLION = "#D55E00"
PURPLE = "#CC79A7"
PALETTE = (BLACK, ORANGE, SKY_BLUE, GREEN, YELLOW, BLUE, VERMILLION, PURPLE)


class Style(NamedTuple):
    """How a method is drawn, in every figure."""

    color: str
    line: str


# Colour tells the value learner and its regulariser, the line flat (solid) from hierarchical.
STYLES = {
    "gcbc": Style(BLACK, "-"),
    "crl": Style(BLACK, "-."),
    "hiql": Style(BLACK, "--"),
    "gciql": Style(YELLOW, "-"),
    "sharsa": Style(YELLOW, "--"),
    "dsharsa": Style(YELLOW, ":"),
    "gcivl": Style(BLUE, "-"),
    "eik-gcivl": Style(ORANGE, "-"),
    "hjb-gcivl": Style(VERMILLION, "-"),
    "h-flow-gcivl": Style(BLUE, "--"),
    "pi-h-flow-eik-gcivl": Style(ORANGE, "--"),
    "pi-h-flow-hjb-gcivl": Style(VERMILLION, "--"),
    "qrl": Style(GREEN, "-"),
    "eik-qrl": Style(SKY_BLUE, "-"),
    "hjb-qrl": Style(PURPLE, "-"),
    "h-flow-qrl": Style(GREEN, "--"),
    "pi-h-flow-eik-qrl": Style(SKY_BLUE, "--"),
    "pi-h-flow-hjb-qrl": Style(PURPLE, "--"),
}

_PANEL_SIZE = 3.6, 2.8
_LEGEND_HEIGHT = 0.3
_LEGEND_COLUMNS = 4
# No dates in the file: same runs, same bytes.
_METADATA = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}


def style(method: str) -> Style:
    """The method's own style; for a method of none, one that follows from its name alone."""
    number = zlib.crc32(method.encode())
    return STYLES.get(method, Style(PALETTE[number % len(PALETTE)], "-."))


def plot_curves(results: Iterable[Result], path: Path, *, order: Sequence[str] = ()) -> None:
    """Draws one panel an environment into the file `path`, its format told by the extension.

    A line is the mean over seeds, its band one standard deviation to each side. Names are ordered
    as in `tables.method_table`. Raises UserError when the format is unknown or the results are not
    comparable.
    """
    extension = path.suffix.removeprefix(".").lower()
    lookup("picture format", FigureCanvasAgg.get_supported_filetypes(), extension)
    cells = stats.cells(results)
    methods = ordered({cell.method for cell in cells}, order)
    environments = ordered({cell.environment for cell in cells}, order)
    legend_rows = -(-len(methods) // _LEGEND_COLUMNS)
    width, height = _PANEL_SIZE
    figure = Figure(
        figsize=(width * len(environments), height + _LEGEND_HEIGHT * legend_rows),
        layout="constrained",
    )
    panels = figure.subplots(1, len(environments), sharey=True, squeeze=False)[0]
    lines = {}
    for panel, environment in zip(panels, environments, strict=True):
        _prepare(panel, environment)
        for method in methods:
            if (method, environment) in cells:
                curve = stats.success_curve(cells[stats.Cell(method, environment)])
                lines[method] = _draw(panel, curve, style(method))
    panels[0].set_ylabel("Success rate (%)")
    figure.legend(
        [lines[method] for method in methods],
        methods,
        loc="outside lower center",
        ncols=_LEGEND_COLUMNS,
        frameon=False,
    )
    with mpl.rc_context({"svg.hashsalt": "pigbench"}), files.replacing_file(path) as file:
        figure.savefig(file, format=extension, dpi=200, metadata=_METADATA.get(extension))


def _prepare(panel: Axes, environment: str) -> None:
    panel.set_title(environment)
    panel.set_xlabel("Training steps")
    panel.set_ylim(0, 100)
    panel.xaxis.set_major_formatter(EngFormatter(sep=""))
    panel.grid(alpha=0.3)
    panel.spines[["top", "right"]].set_visible(False)


def _draw(panel: Axes, curve: dict[int, Estimate], look: Style) -> Line2D:
    steps = list(curve)
    mean = [value.mean for value in curve.values()]
    deviation = [value.deviation or 0.0 for value in curve.values()]
    # Markers, because a curve of one evaluation has no line.
    (line,) = panel.plot(steps, mean, look.line, color=look.color, marker=".", clip_on=False)
    lower = [m - d for m, d in zip(mean, deviation, strict=True)]
    upper = [m + d for m, d in zip(mean, deviation, strict=True)]
    panel.fill_between(steps, lower, upper, color=look.color, alpha=0.2, linewidth=0)
    return line
