"""What `pigbench bench device` measures, and in what sizes."""

from dataclasses import dataclass, field
from typing import Any

from pigbench.errors import require
from pigbench.support.typed import MAY_BE_EMPTY


def _skippable(*sizes: Any) -> Any:
    """Sizes of rows; given none, there are no such rows."""
    return field(default=sizes, metadata={MAY_BE_EMPTY: True})


@dataclass(frozen=True)
class Sizes:
    """What to measure, and how much of it at once."""

    environments: tuple[str, ...] = ("cube-double", "cube-quadruple")
    """Environments; only control steps are measured in all of them, the rest in the first."""
    engines: tuple[str, ...] = ()
    """Physics engines, by default all; generation and evaluation use the first."""
    simulations: tuple[int, ...] = _skippable(*(4**power for power in range(4, 11)))
    """Simulations at once, as long as more of them give more control steps per second. Where an
    engine is slow, which MJX's are on a CPU, they are 1 and 16 instead."""
    generation: int = 4096
    """Simulations at once during data generation."""
    episodes: int = 50
    """Episodes per task in an evaluation."""
    picks: int = 64
    """Cubes picked and placed at once."""
    methods: tuple[str, ...] = ("gcivl", "hjb-gcivl", "pi-h-flow-hjb-gcivl")
    """Methods whose updates are timed."""
    seeds: tuple[int, ...] = _skippable(1, 8)
    """Seeds trained together at preset paper."""
    cpu_seeds: tuple[int, ...] = _skippable(1, 8, 32)
    """Seeds trained together at preset cpu."""
    precisions: tuple[str, ...] = _skippable("highest", "BF16_BF16_F32", "high")
    """Precisions of matrix products to compare with JAX's default, at preset paper."""
    seconds: float = 0.5
    """Length of a turn in seconds; a row has three turns."""

    def __post_init__(self) -> None:
        require(self, lambda x: x >= 1, "at least 1", "generation", "episodes", "picks")
        require(self, lambda x: x > 0, "more than 0", "seconds")
        counts = "simulations", "seeds", "cpu_seeds"
        require(self, lambda many: all(x >= 1 for x in many), "numbers from 1", *counts)
        require(self, lambda names: names, "one name or more", "environments", "methods")
