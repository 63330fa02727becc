"""The figure of residuals by contact mode: one panel per quantity, one box per mode."""

from pathlib import Path

import numpy as np
from jaxtyping import Shaped

from pigbench.analysis.residuals import Residuals, by_mode
from pigbench.report import canvas, styles

_PANELS = {
    "eikonal": "Eikonal residual",
    "hjb": "HJB residual",
    "gradient": "Norm of the gradient",
    "object": "Share along the object",
}
_LOGARITHMIC = "eikonal", "hjb", "gradient"
_PANEL = 2.2, 2.6  # inches
_WHISKERS = 5, 95  # percentiles


def draw(
    modes: Shaped[np.ndarray, "batch"], residuals: Residuals, path: Path, *, title: str
) -> None:
    """Draw the quantities into the file `path`: boxes are quartiles, whiskers 5 to 95 %."""
    with canvas.look():
        figure, panels = canvas.grid(1, len(_PANELS), panel=_PANEL, legend=[], share_y=False)
        for panel, (quantity, label) in zip(panels[0], _PANELS.items(), strict=True):
            values = by_mode(modes, getattr(residuals, quantity))
            panel.boxplot(
                list(values.values()),
                tick_labels=list(values),
                whis=_WHISKERS,
                widths=0.6,
                showfliers=False,
                medianprops={"color": styles.VERMILLION},
            )
            if quantity in _LOGARITHMIC:
                canvas.log_axis(panel, "y")
            panel.set_title(label)
            panel.grid(visible=False, axis="x")
        figure.suptitle(title)
        canvas.save(figure, path)
