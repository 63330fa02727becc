"""What is measured of a run's value and of its subgoals, as tables with captions."""

from collections.abc import Iterator, Mapping

import numpy as np
from jaxtyping import Float, Shaped

from pigbench.agents import Agent
from pigbench.agents.residuals import HJB
from pigbench.analysis.modes import MODES
from pigbench.analysis.residuals import Residuals, by_mode, equation
from pigbench.analysis.subgoals import Distances
from pigbench.report.formats import markdown_grid

_RESIDUALS = {
    "Eikonal residual": 1,
    "HJB residual": 1,
    "gradient norm": 1,
    "along robot (%)": 100,
    "along object (%)": 100,
}
"""Column -> factor; in the order of `Residuals`."""

_RESIDUALS_CAPTION = (
    "Medians over transitions of the data, except for the share of each mode. The gradient is that "
    "of the value with respect to the state; along robot and object are the shares of its square. "
    "Goals, coordinates and constants are those with which the run trains its value (direction of "
    "HJB: {direction!r})."
)

_PERCENTILES = 50, 90
_SUBGOALS_CAPTION = (
    "Distances in mm between a simulation after K = {steps} control steps and the data then: "
    "medians and 90th percentiles over stretches, by the contact mode in which they begin. The low "
    "level's subgoal is either the data's state K steps after the current step, as in training, or "
    "fixed at the stretch's end; both levels have that end as their goal."
)
_GRASPS_CAPTION = (
    "Distances in mm in x and y from a subgoal's pinch point to the cube: medians and 90th "
    "percentiles over states of the data after which the gripper takes hold of a cube within K = "
    "{steps} control steps, with goals more than 2 K ahead, drawn as in training."
)


def residuals(modes: Shaped[np.ndarray, "batch"], measured: Residuals, agent: Agent) -> str:
    """Medians of the agent's residuals, by contact mode."""
    header = ("mode", "share (%)", *_RESIDUALS)
    caption = _RESIDUALS_CAPTION.format(direction=equation(HJB, agent).direction)
    return _with_caption([header, *_residual_lines(modes, measured)], caption)


def subgoals(
    modes: Shaped[np.ndarray, "batch"], distances: Mapping[str, Distances], *, steps: int
) -> str:
    """Distances after stretches of K = `steps`, by contact mode and way."""
    header = ("mode", "stretches", "how", *_columns("pinch"), *_columns("cube"))
    caption = _SUBGOALS_CAPTION.format(steps=steps)
    return _with_caption([header, *_subgoal_lines(modes, distances)], caption)


def grasps(misses: Mapping[str, Float[np.ndarray, "batch"]], *, steps: int) -> str:
    """Distances from the cube that is held K = `steps` later, by whose the subgoals are."""
    header = ("subgoal", "grasps", *_columns("off"))
    lines = [(whose, str(len(off)), *_millimetres(off)) for whose, off in misses.items()]
    return _with_caption([header, *lines], _GRASPS_CAPTION.format(steps=steps))


def _with_caption(lines: list[tuple[str, ...]], caption: str) -> str:
    return f"{markdown_grid(lines)}\n\n{caption}\n"


def _residual_lines(
    modes: Shaped[np.ndarray, "batch"], measured: Residuals
) -> Iterator[tuple[str, ...]]:
    medians = [
        {mode: factor * np.median(values) for mode, values in by_mode(modes, column).items()}
        for column, factor in zip(measured, _RESIDUALS.values(), strict=True)
    ]
    for mode in MODES:
        if mode in medians[0]:
            share = f"{100 * np.mean(modes == mode):.1f}"
            yield mode, share, *(f"{column[mode]:.3g}" for column in medians)


def _subgoal_lines(
    modes: Shaped[np.ndarray, "batch"], distances: Mapping[str, Distances]
) -> Iterator[tuple[str, ...]]:
    for mode in MODES:
        chosen = modes == mode
        if not chosen.any():
            continue
        for way, apart in distances.items():
            yield mode, str(chosen.sum()), way, *_millimetres(*(x[chosen] for x in apart))


def _columns(what: str) -> list[str]:
    return [f"{what} {percentile} %" for percentile in _PERCENTILES]


def _millimetres(*columns: Float[np.ndarray, "batch"]) -> list[str]:
    return [f"{1e3 * x:.1f}" for column in columns for x in np.percentile(column, _PERCENTILES)]
