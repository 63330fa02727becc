"""An example's figures: fits beside the truth, and an extended figure with errors."""

from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np
from jaxtyping import Float, Shaped
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pigbench.report.styles import BLACK, STYLES
from pigbench.toy.errors import errors
from pigbench.toy.fit import LOSSES
from pigbench.toy.problem import Example, Mode
from pigbench.toy.settings import Settings
from pigbench.toy.study import SIDE, ToyOutcome, grid_states, section_states

LABELS = {"baseline": "Baseline", "hjb": "HJB", "eikonal": "Eikonal"}
# A loss has the colour of the method with that regulariser.
METHODS = {"baseline": "gcivl", "hjb": "hjb-gcivl", "eikonal": "eik-gcivl"}

Panels = Shaped[np.ndarray, "panel"]  # each an `Axes`
Surface = Float[np.ndarray, "batch"]  # of `grid_states`

_PANEL = 2.3  # inches
_DPI = 100  # surfaces are smooth: more would only make files larger
_CONTOURS = 8


def overview(example: Example, outcomes: Sequence[ToyOutcome], settings: Settings) -> Figure:
    """One row per mode: d*, the fits (means over seeds), and all of them along the section."""
    modes = list(_by_mode(outcomes))
    figure, rows = _panels(len(modes), len(LOSSES) + 2)
    for row, (mode, fits) in zip(rows, modes, strict=True):
        truth = np.asarray(mode.cost_to_go(grid_states(settings)))
        titles = ["$d^*$", *(LABELS[fit.loss] for fit in fits)]
        _draw_costs(row[:-1], [truth, *(fit.grid.mean(axis=0) for fit in fits)], settings)
        _name(row[:-1], [f"{title}, {mode.name}" for title in titles], example)
        _draw_section(row[-1], mode, fits, settings)
    rows[0][-1].legend(fontsize="small")
    return figure


def extended(example: Example, outcomes: Sequence[ToyOutcome], settings: Settings) -> Figure:
    """Two rows per mode, the fits and their errors (means over seeds); one column per loss."""
    modes = list(_by_mode(outcomes))
    figure, rows = _panels(2 * len(modes), len(LOSSES))
    for (mode, fits), upper, lower in zip(modes, rows[::2], rows[1::2], strict=True):
        titles = [f"{LABELS[fit.loss]}, {mode.name}" for fit in fits]
        _draw_costs(upper, [fit.grid.mean(axis=0) for fit in fits], settings)
        _draw_errors(lower, [errors(fit, settings).mean(axis=0) for fit in fits], settings)
        _name(upper, titles, example)
        _name(lower, titles, example)
    return figure


def _by_mode(outcomes: Sequence[ToyOutcome]) -> Iterator[tuple[Mode, list[ToyOutcome]]]:
    for mode, fits in groupby(outcomes, key=lambda outcome: outcome.mode):
        yield mode, list(fits)


def _panels(rows: int, columns: int) -> tuple[Figure, Shaped[np.ndarray, "{rows} {columns}"]]:
    figure = Figure(figsize=(_PANEL * columns + 0.8, _PANEL * rows), layout="constrained", dpi=_DPI)
    return figure, figure.subplots(rows, columns, squeeze=False)


def _name(panels: Panels, titles: Sequence[str], example: Example) -> None:
    for panel, title in zip(panels, titles, strict=True):
        panel.set_title(title, fontsize="medium")
        panel.set_xlabel(example.axes[0])
    panels[0].set_ylabel(example.axes[1])


def _draw_costs(panels: Panels, surfaces: Sequence[Surface], settings: Settings) -> None:
    """Draw colours and contours, the same for all panels."""
    low, high = min(map(np.min, surfaces)), max(map(np.max, surfaces))
    _draw(panels, surfaces, settings, (low, high), "cividis", r"$\hat d$")
    first, second = np.asarray(grid_states(settings)).T.reshape(2, SIDE, SIDE)
    for panel, surface in zip(panels, surfaces, strict=True):
        panel.contour(
            first,
            second,
            surface.reshape(SIDE, SIDE),
            levels=np.linspace(low, high, _CONTOURS + 2)[1:-1],
            colors="white",
            linewidths=0.7,
            linestyles="solid",
        )


def _draw_errors(panels: Panels, surfaces: Sequence[Surface], settings: Settings) -> None:
    """Draw colours that are white at 0, the same for all panels."""
    largest = max(np.abs(surface).max() for surface in surfaces)
    _draw(panels, surfaces, settings, (-largest, largest), "PuOr", r"$\hat d - d^*$")


def _draw(
    panels: Panels,
    surfaces: Sequence[Surface],
    settings: Settings,
    limits: tuple[np.floating, np.floating],
    colors: str,
    label: str,
) -> None:
    width = settings.half_width
    images = [
        panel.imshow(
            surface.reshape(SIDE, SIDE),
            origin="lower",
            extent=(-width, width, -width, width),
            cmap=colors,
            vmin=limits[0],
            vmax=limits[1],
        )
        for panel, surface in zip(panels, surfaces, strict=True)
    ]
    for panel in panels:
        panel.grid(visible=False)
        panel.spines[:].set_visible(True)
    panels[0].figure.colorbar(images[0], ax=list(panels), label=label, pad=0.01, aspect=15)


def _draw_section(panel: Axes, mode: Mode, fits: Sequence[ToyOutcome], settings: Settings) -> None:
    """Draw d* and the fits, with a band of one standard deviation over seeds."""
    states = section_states(mode, settings)
    position = np.asarray(states[:, 1])
    panel.plot(position, mode.cost_to_go(states), color=BLACK, linestyle=":", label="$d^*$")
    for fit in fits:
        color = STYLES[METHODS[fit.loss]].color
        mean = fit.section.mean(axis=0)
        deviation = fit.section.std(axis=0, ddof=min(1, len(fit.section) - 1))
        panel.plot(position, mean, color=color, label=LABELS[fit.loss])
        panel.fill_between(
            position, mean - deviation, mean + deviation, color=color, alpha=0.2, linewidth=0
        )
    panel.set_title(mode.name, fontsize="medium")
    panel.set_xlabel(mode.section.label.format(*np.asarray(states[0])))
