"""Tables of how close the simulations, and the data made in them, are to OGBench's."""

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
from jaxtyping import Bool

from pigbench.fidelity import closed_loop, peer, replay
from pigbench.fidelity.closed_loop import Successes
from pigbench.fidelity.distributions import Comparison
from pigbench.fidelity.replay import Errors, Outcomes, Windows

FidelityTable = Sequence[tuple[str, ...]]
"""Lines of cells, header first."""

Simulator = tuple[str, str]
"""Names of a physics engine and a profile."""

PERCENTILE = 95
_HORIZONS = (1, 10, replay.WINDOW)  # control steps after which errors are compared
_CLOSE, _NEAR = 1e-4, 2e-3  # metres

# Column -> the error's field, and the factor that converts it to the column's unit.
_COLUMNS = {
    "pinch (mm)": ("pinch", 1e3),
    "opening": ("opening", 1),
    "contact": ("contact", 1),
    "cube (mm)": ("cube", 1e3),
    "turn (deg)": ("turn", np.degrees(1)),
}


def errors(windows: Mapping[Simulator, Windows]) -> FidelityTable:
    """Percentiles of the errors over windows, by simulator, situation and control steps."""
    kinds = ("engine", "physics", "situation", "steps", "windows")
    shares = (f"cube within {1e3 * _CLOSE:g} mm", f"{1e3 * _NEAR:g} mm")
    lines = itertools.chain.from_iterable(_error_lines(*item) for item in windows.items())
    return [(*kinds, *_COLUMNS, *shares), *lines]


def outcomes(ends: Mapping[Simulator, Outcomes]) -> FidelityTable:
    """How many sub-tasks have the same outcome, by simulator."""
    lines = [
        (
            *name,
            str(len(one.grasped)),
            _share(one.grasped == one.grasped_here),
            _share(one.placed == one.placed_here),
        )
        for name, one in ends.items()
    ]
    return [("engine", "physics", "sub-tasks", "same grasp", "same placement"), *lines]


def quantities(compared: Iterable[tuple[str, Mapping[str, Comparison]]]) -> FidelityTable:
    """Both means of each quantity and the test of them, given policies with their comparisons."""
    lines = [
        (name, policy, f"{one:.3g}", f"{other:.3g}", f"{statistic:.2f}", f"{p:.2g}")
        for policy, by_quantity in compared
        for name, (one, other, statistic, p) in by_quantity.items()
    ]
    return [("quantity", "policy", peer.NAME, "pigbench", "KS statistic", "p"), *lines]


def pairs(tasks: Sequence[str], successes: Successes) -> FidelityTable:
    """Pairs of episodes by outcome, and success in each simulator, by task and in all tasks."""
    lines = [
        _pair_line(name, Successes(*pair)) for name, *pair in zip(tasks, *successes, strict=True)
    ]
    ends = ("both succeed", "only pigbench", f"only {peer.NAME}", "neither")
    header = ("task", *ends, "pigbench", peer.NAME, "McNemar's p")
    return [header, *lines, _pair_line("all tasks", successes)]


def _error_lines(name: Simulator, windows: Windows) -> Iterator[tuple[str, ...]]:
    for situation, horizon in itertools.product(replay.SITUATIONS, _HORIZONS):
        chosen = windows.situations[horizon - 1] == situation
        if not chosen.any():
            continue
        found = Errors(*(error[horizon - 1, chosen] for error in windows.errors))
        yield (
            *name,
            situation,
            str(horizon),
            str(chosen.sum()),
            *(
                f"{scale * np.percentile(getattr(found, field), PERCENTILE):.2g}"
                for field, scale in _COLUMNS.values()
            ),
            *(_share(found.cube <= distance) for distance in (_CLOSE, _NEAR)),
        )


def _pair_line(name: str, successes: Successes) -> tuple[str, ...]:
    *counts, p = closed_loop.compare(successes)
    return (name, *map(str, counts), *map(_share, successes), f"{p:.2g}")


def _share(flags: Bool[np.ndarray, "*axes"]) -> str:
    return f"{100 * flags.mean():.1f} %"
