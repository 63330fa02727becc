"""Interactive Bokeh figures of one environment, as JSON that Bokeh's script draws.

Models of a method are named after it, so that a page can hide and show them. Models whose colours
differ between light and dark ground are tagged with both.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from bokeh.embed import json_item
from bokeh.models import (
    ColumnDataSource,
    FactorRange,
    HoverTool,
    Model,
    NumeralTickFormatter,
    Range1d,
    TeeHead,
    Whisker,
)
from bokeh.plotting import figure

from pigbench.page.looks import Look, Shade
from pigbench.report import stats
from pigbench.report.bootstrap import LEVEL
from pigbench.report.scoring import Groups
from pigbench.report.stats import Estimate, Result

_INK = Shade("#4a4d55", "#b9bcc4")
_RULE = Shade("#e6e6ea", "#31343c")
_GROUND = Shade("#ffffff", "#1d1f25")
_FONT = "system-ui, sans-serif"
_TOOLS = "xpan,box_zoom,reset,save"
_AXIS = 80  # pixels
_BAR = 9  # at least
_LETTER = 8
_GAP = 1.4  # bars, between groups
_TOOLTIPS = [("", "@method"), ("value", "@shown"), ("seeds", "@seeds")]

Json = dict[str, Any]


def curves(
    finished: Mapping[str, Sequence[Result]],
    unfinished: Mapping[str, Sequence[Result]],
    looks: Mapping[str, Look],
) -> Json:
    """Success over training by method: means over seeds, and unfinished runs one by one.

    The band is one standard deviation to each side.
    """
    plot = _figure(height=340, x_axis_label="training steps", y_axis_label="success (%)")
    plot.xaxis.formatter = NumeralTickFormatter(format="0.[0]a")
    marks = []
    for method, group in finished.items():
        curve = stats.success_curve(group)
        data = {"step": list(curve)} | _columns(method, curve.values())
        marks.append(_line(plot, method, data, looks[method]))
        if any(estimate.deviation is not None for estimate in curve.values()):
            band = plot.varea(
                "step", "low", "high", source=marks[-1].data_source, name=method, fill_alpha=0.15
            )
            _shade(band.glyph, fill_color=looks[method].shade)
    for method, group in unfinished.items():
        for result in group:
            curve = {step: Estimate(value) for step, value in stats.run_curve(result).items()}
            told = f"{method}, seed {result.run.config.seed}, unfinished"
            data = {"step": list(curve)} | _columns(told, curve.values())
            marks.append(_line(plot, method, data, looks[method], alpha=0.45))
    tooltips = [*_TOOLTIPS, ("step", "@step{0,0}")]
    plot.add_tools(HoverTool(tooltips=tooltips, renderers=marks, point_policy="snap_to_data"))
    return _json(plot)


def bars(groups: Mapping[str, Groups], quantity: str, looks: Mapping[str, Look]) -> Json:
    """One bar per method in each group, with a whisker of one standard deviation each way.

    A dash takes the place of an unknown bar.
    """
    names = list(dict.fromkeys(name for own in groups.values() for name in own))
    places = [(name, method) for name in names for method in groups]
    widths = _BAR * (len(places) + _GAP * len(names)), _LETTER * max(map(len, names)) * len(names)
    plot = _figure(
        height=280,
        min_width=int(_AXIS + max(widths)),
        x_range=FactorRange(factors=places, group_padding=_GAP, range_padding=0.02),
        y_axis_label=quantity,
    )
    plot.xgrid.visible = False
    axis: Any = plot.xaxis[0]
    axis.update(
        major_label_text_font_size="0px",  # the legend names the methods
        major_tick_line_color=None,
        group_text_font=_FONT,
        group_text_font_style="normal",
        separator_line_color=None,
    )
    _shade(axis, **_axis(axis), group_text_color=_INK)
    drawn = []
    for method, own in groups.items():
        known = {name: estimate for name, estimate in own.items() if estimate is not None}
        source = ColumnDataSource(
            {"place": [(name, method) for name in known], "group": list(known)}
            | _columns(method, known.values())
        )
        drawn.append(_bars(plot, method, source, looks[method]))
        if any(estimate.deviation is not None for estimate in known.values()):
            plot.add_layout(_whiskers(method, source))
        _dashes(plot, method, [(name, method) for name in own if name not in known], looks[method])
    tooltips = [("", "@group"), *_TOOLTIPS, ("interval", "@interval")]
    plot.add_tools(HoverTool(tooltips=tooltips, renderers=drawn))
    return _json(plot)


def _figure(**options: Any) -> figure:
    plot = figure(
        sizing_mode="stretch_width",
        tools=_TOOLS,
        active_drag=None,  # a finger scrolls the page
        y_range=Range1d(start=-2, end=102),
        background_fill_color=None,
        border_fill_color=None,
        outline_line_color=None,
        toolbar_location="right",
        **options,
    )
    plot.toolbar.logo = None
    plot.toolbar.autohide = True
    plot.yaxis.ticker = [0, 25, 50, 75, 100]
    for axis in plot.axis:
        axis.axis_label_text_font = axis.major_label_text_font = _FONT
        axis.axis_label_text_font_style = "normal"
        axis.minor_tick_line_color = None
        axis.major_tick_in = 0
        _shade(axis, **_axis(axis))
    for grid in plot.grid:
        _shade(grid, grid_line_color=_RULE)
    return plot


def _axis(axis: Any) -> dict[str, Shade]:
    """The colours of an axis, including those of its ticks if it has any."""
    names = ["axis_label_text_color", "major_label_text_color"]
    return (
        dict.fromkeys(names, _INK)
        | {"axis_line_color": _RULE}
        | ({} if axis.major_tick_line_color is None else {"major_tick_line_color": _RULE})
    )


def _line(plot: figure, method: str, data: Mapping[str, Any], own: Look, alpha: float = 1.0) -> Any:
    """Draw a method's curve; returns its marks, which get tooltips."""
    source = ColumnDataSource(dict(data))
    dash = [round(float(length)) for length in own.dash.split()]
    line = plot.line(
        "step", "value", source=source, name=method, line_width=1.8, line_dash=dash, alpha=alpha
    )
    marks = plot.scatter(
        "step", "value", source=source, name=method, marker=own.marker, size=6, alpha=alpha
    )
    _shade(line.glyph, line_color=own.shade)
    _shade(marks.glyph, line_color=own.shade, fill_color=own.shade)
    return marks


def _bars(plot: figure, method: str, source: ColumnDataSource, own: Look) -> Any:
    drawn = plot.vbar(
        "place",
        top="value",
        width=0.9,
        source=source,
        name=method,
        line_color=None,
        hatch_pattern=own.hatch,
        hatch_scale=7,
        hatch_weight=0.8,
    )
    _shade(drawn.glyph, fill_color=own.shade, hatch_color=_GROUND)
    return drawn


def _whiskers(method: str, source: ColumnDataSource) -> Whisker:
    upper, lower = TeeHead(size=4), TeeHead(size=4)
    whiskers = Whisker(
        source=source,
        base="place",
        lower="low",
        upper="high",
        upper_head=upper,
        lower_head=lower,
        name=method,
    )
    for model in (upper, lower, whiskers):
        _shade(model, line_color=_INK)
    return whiskers


def _dashes(plot: figure, method: str, places: Sequence[tuple[str, str]], own: Look) -> None:
    source = ColumnDataSource({"place": list(places), "text": ["–"] * len(places)})
    drawn = plot.text("place", 0, "text", source=source, name=method, text_align="center")
    _shade(drawn.glyph, text_color=own.shade)


def _columns(method: str, estimates: Iterable[Estimate]) -> dict[str, list[Any]]:
    """The columns of estimates that a figure and its tooltips show."""
    estimates = list(estimates)
    return {
        "method": [method] * len(estimates),
        "value": [estimate.value for estimate in estimates],
        "low": [estimate.value - (estimate.deviation or 0.0) for estimate in estimates],
        "high": [estimate.value + (estimate.deviation or 0.0) for estimate in estimates],
        "shown": [_with_deviation(estimate) for estimate in estimates],
        "interval": [_interval(estimate) for estimate in estimates],
        "seeds": [estimate.seeds for estimate in estimates],
    }


def _with_deviation(estimate: Estimate) -> str:
    deviation = "" if estimate.deviation is None else f" ± {estimate.deviation:.1f}"
    return f"{estimate.value:.1f}{deviation}"


def _interval(estimate: Estimate) -> str:
    if estimate.interval is None:
        return "–"
    return f"{estimate.interval.low:.1f} to {estimate.interval.high:.1f} ({LEVEL} %)"


def _shade(model: Model, **shades: Shade) -> None:
    """Give a model its colours on light ground, and tag it with those on light and dark."""
    model.update(**{name: shade.light for name, shade in shades.items()})
    model.tags = [{name: list(shade) for name, shade in shades.items()}]


def _json(plot: figure) -> Json:
    return dict(json_item(plot))
