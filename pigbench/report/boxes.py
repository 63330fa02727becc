"""The paper's box plot: a box per method, a dot per environment, and a large one, their mean."""

from collections.abc import Iterable, Mapping, Sequence

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from pigbench.report import canvas, comparison
from pigbench.report.order import ordered
from pigbench.report.representations import by_representation, representation, shown_names
from pigbench.report.scoring import Scoring, score_remarks, success, wording
from pigbench.report.stats import Result, base
from pigbench.report.styles import BLACK, GREY, styles
from pigbench.support.grouping import grouped

_HEIGHT = 3.6  # inches
_BOX = 0.3
_GAP = 0.5  # between methods, in boxes
_MARGIN = 3
_FLAT = "full"  # flat methods see the full state
_DOT = {"marker": "o", "linestyle": "none", "markeredgecolor": BLACK, "zorder": 3}
_ENVIRONMENT = {**_DOT, "markersize": 3, "color": BLACK}
_MEAN = {**_DOT, "markersize": 6, "color": "white", "zorder": 4}


def draw(results: Sequence[Result], order: Sequence[str], scoring: Scoring) -> Figure:
    """Boxes of means over seeds in environments that all methods have; variants are side by side.

    Boxes and means are the fuller of colour the narrower the representation. Raises UserError if
    there is no such environment.
    """
    cells = comparison.common(scoring.cells(results))
    low_levels = {cell.method: group[0].representation for cell, group in cells.items()}
    methods = by_representation(ordered(low_levels, order), low_levels)
    places, looks = _places(methods), styles(methods)
    handles = _handles(name for name in low_levels.values() if name is not None)
    width = _BOX * (max(places.values()) + _MARGIN)
    figure, grid = canvas.grid(1, 1, panel=(width, _HEIGHT), legend=list(handles))
    panel = grid[0, 0]
    for method in methods:
        group = [results for cell, results in cells.items() if cell.method == method]
        values = [success(results, scoring).value for results in group]
        _add_box(panel, places[method], values, looks[method].color, _fill(low_levels[method]))
    panel.set_ylim(0, 100)
    environments = ", ".join(ordered({cell.environment for cell in cells}, order))
    title = f"{wording(cells, scoring)}, over {environments}"
    panel.set_title(canvas.wrapped(title, figure.get_figwidth()))
    panel.set_ylabel("success (%)")
    panel.grid(visible=False, axis="x")
    ticks = _ticks(places, low_levels)
    panel.set_xticks(
        list(ticks.values()), list(ticks), rotation=40, ha="right", rotation_mode="anchor"
    )
    canvas.add_remarks(figure, score_remarks(cells, scoring))
    canvas.add_legend(figure, handles)
    return figure


def _places(methods: Sequence[str]) -> dict[str, float]:
    """The position of each method's box, with a gap after the variants of a method."""
    places: dict[str, float] = {}
    place = 0.0
    for index, method in enumerate(methods):
        if index > 0:
            place += 1 if base(method) == base(methods[index - 1]) else 1 + _GAP
        places[method] = place
    return places


def _ticks(places: Mapping[str, float], low_levels: Mapping[str, str | None]) -> dict[str, float]:
    """Names and their positions, in the middle of the boxes that share them."""
    return {
        name: sum(places[method] for method in own) / len(own)
        for name, own in grouped(places, shown_names(low_levels).__getitem__).items()
    }


def _add_box(panel: Axes, place: float, values: Sequence[float], color: str, fill: float) -> None:
    face = _tinted(color, fill)
    panel.boxplot(
        [values],
        positions=[place],
        widths=0.7,
        patch_artist=True,
        manage_ticks=False,
        showfliers=False,
        boxprops={"edgecolor": color, "facecolor": face},
        medianprops={"color": color, "linewidth": 1.6},
        whiskerprops={"color": color},
        capprops={"color": color},
    )
    panel.plot([place] * len(values), values, clip_on=False, **_ENVIRONMENT)
    mean = sum(values) / len(values)
    (dot,) = panel.plot([place], [mean], clip_on=False, **_MEAN)
    dot.set_color(face)


def _handles(representations: Iterable[str]) -> dict[str, Artist]:
    boxes = {
        f"low level: {representation(name).title}": Patch(
            edgecolor=GREY, facecolor=_tinted(GREY, _fill(name))
        )
        for name in sorted(set(representations), key=_fill)
    }
    return {
        "an environment": Line2D([], [], **_ENVIRONMENT),
        "mean over environments": Line2D([], [], **_MEAN),
        **boxes,
    }


def _fill(name: str | None) -> float:
    return representation(name or _FLAT).fill


def _tinted(color: str, fill: float) -> str:
    """An opaque mixture of a colour with white."""
    red, green, blue = (1 - fill * (1 - part) for part in to_rgb(color))
    return to_hex((red, green, blue))
