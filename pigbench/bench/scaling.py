"""How the rate of control steps scales with simultaneous simulations and with cubes."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from pigbench import envs
from pigbench.bench import simulation
from pigbench.bench.timing import Contender, Timing
from pigbench.report import styles

_PANEL = 3.2, 2.4  # inches


class Point(NamedTuple):
    """One measurement: a number of simultaneous simulations of an environment."""

    environment: str
    simulations: int

    @property
    def name(self) -> str:
        """Both as text."""
        return f"{self.environment}, {self.simulations:,}"

    @property
    def cubes(self) -> int:
        """Cubes in the environment."""
        return envs.SPECS[self.environment].num_cubes


def contenders(points: Iterable[Point], *, engine: str, profile: str) -> list[Contender]:
    """The control steps of each point, once."""
    return [
        simulation.steps(
            envs.make(point.environment, engine=engine, profile=profile),
            point.simulations,
            name=point.name,
        )
        for point in dict.fromkeys(points)
    ]


def table(timings: Mapping[str, Timing]) -> list[tuple[str, ...]]:
    """One line per point, with a header."""
    lines = [
        (name, f"{1 / timing.median:,.0f}", f"{timing.first:.1f}")
        for name, timing in timings.items()
    ]
    return [("environment, simulations", "control steps per second", "s of the first call"), *lines]


def draw(
    timings: Mapping[str, Timing],
    by_simulations: Sequence[Point],
    by_cubes: Sequence[Point],
    path: Path,
) -> None:
    """Plot control steps per second over simulations and over cubes into the file `path`."""
    from pigbench.report import canvas

    with canvas.look():
        figure, panels = canvas.grid(1, 2, panel=_PANEL, legend=[])
        left, right = panels[0]
        for panel, points, what in (
            (left, by_simulations, "simulations"),
            (right, by_cubes, "cubes"),
        ):
            shown = dict.fromkeys(points)
            counts = [getattr(point, what) for point in shown]
            rates = [1 / timings[point.name].median for point in shown]
            panel.plot(counts, rates, marker="o", color=styles.BLUE)
            panel.set_xscale("log", base=2)
            panel.set_xticks(counts, labels=[f"{count:,}" for count in counts])
            panel.set_xlabel(what)
        left.set_ylim(bottom=0)  # for both panels
        left.set_title(by_simulations[0].environment)
        right.set_title(f"{by_cubes[0].simulations:,} simulations")
        left.set_ylabel("control steps per second")
        canvas.save(figure, path)
