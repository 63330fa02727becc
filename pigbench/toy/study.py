"""An example's modes fitted under every loss, evaluated on a grid and along a line."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from pigbench.toy.fit import LOSSES, fit, predict
from pigbench.toy.problem import Example, Mode, States
from pigbench.toy.settings import Settings

SIDE = 101
"""Points along a side of the grid and along a section."""


class ToyOutcome(NamedTuple):
    """Fits of one mode under one loss, one per seed."""

    mode: Mode
    loss: str
    grid: Float[np.ndarray, "seed batch"]  # of `grid_states`
    section: Float[np.ndarray, "seed section"]  # of `section_states`


def grid_states(settings: Settings) -> States:
    """`SIDE`^2 states over the square; the first coordinate varies fastest."""
    side = jnp.linspace(-settings.half_width, settings.half_width, SIDE)
    return jnp.stack(jnp.meshgrid(side, side), axis=-1).reshape(-1, 2)


def section_states(mode: Mode, settings: Settings) -> States:
    """`SIDE` states along the mode's section."""
    return settings.half_width * mode.section.points(SIDE)


def study(
    example: Example,
    *,
    seeds: Sequence[int],
    settings: Settings,
    report: Callable[[int, str], None],
) -> list[ToyOutcome]:
    """Fit every mode of the example under every loss; outcomes are ordered by mode.

    `report` is called with the number of further updates done and their loss.
    """
    return [outcome for modes in example.fits for outcome in _fits(modes, seeds, settings, report)]


def _fits(
    modes: Sequence[Mode],
    seeds: Sequence[int],
    settings: Settings,
    report: Callable[[int, str], None],
) -> list[ToyOutcome]:
    params = {
        loss: fit(
            modes,
            regularizer,
            seeds=seeds,
            settings=settings,
            report=lambda amount, loss=loss: report(amount, loss),
        )
        for loss, regularizer in LOSSES.items()
    }

    def values(loss: str, number: int, states: States) -> Float[np.ndarray, "seed batch"]:
        each = jax.vmap(predict, (None, 0, None, None))
        return np.asarray(each(settings, params[loss], number, states))

    return [
        ToyOutcome(
            mode,
            loss,
            grid=values(loss, number, grid_states(settings)),
            section=values(loss, number, section_states(mode, settings)),
        )
        for number, mode in enumerate(modes)
        for loss in LOSSES
    ]
