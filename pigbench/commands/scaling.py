"""`pigbench bench scale` and `bench memory`: the cost of more simulations and more cubes."""

import dataclasses
import itertools
from collections.abc import Mapping
from pathlib import Path

import tyro

from pigbench import devices, envs
from pigbench.bench import scaling, simulation
from pigbench.bench.scaling import Point
from pigbench.bench.timing import Timing
from pigbench.commands.bench import Turns, measure, save
from pigbench.errors import UserError
from pigbench.report import canvas
from pigbench.report.formats import markdown_grid
from pigbench.support import files, memory
from pigbench.support.progress import Progress


@dataclasses.dataclass(frozen=True)
class Scale:
    """Time control steps under random actions: one environment in batches of many sizes, and
    environments of 1 to 8 cubes in batches of one size.
    """

    environment: tyro.conf.Positional[str] = "cube-double"
    """Environment to time in batches of many sizes."""
    simulations: tuple[int, ...] = (1, 4, 16, 64, 256, 1024, 4096)
    """Simulations at once."""
    environments: tuple[str, ...] = envs.names()
    """Environments to compare with each other."""
    batch: int = 256
    """Simulations at once when comparing environments."""
    engine: str = dataclasses.field(default_factory=envs.default_engine)
    """Physics engine."""
    physics: str = "exact"
    """Physics profile."""
    turns: Turns = dataclasses.field(default_factory=lambda: Turns(turns=3, seconds=1.0))
    """How the batches take turns; a turn is at least one control step."""
    out: Path = Path("scaling.png")
    """File for the plot."""
    json: Path | None = None
    """File for the result as JSON, with the machine and versions."""

    def run(self) -> None:
        """Measure, print a table and draw a plot."""
        canvas.check_path(self.out)
        files.require_files(self.json)
        _check(*self.simulations, self.batch)
        grown = [Point(self.environment, count) for count in self.simulations]
        compared = [Point(name, self.batch) for name in self.environments]
        contenders = [
            simulation.steps(
                envs.make(point.environment, engine=self.engine, profile=self.physics),
                point.simulations,
                name=point.name,
            )
            for point in dict.fromkeys([*grown, *compared])
        ]
        timings = measure("bench scale", contenders, self.turns)
        print(markdown_grid([_HEADER, *map(_line, timings.items())]))
        scaling.draw(_of(timings, grown), _of(timings, compared), self.out)
        print(f"{self.out} is drawn")
        save(self.json, self, timings)


_HEADER = ("environment, simulations", "control steps per second", "s of the first call")


def _line(item: tuple[str, Timing]) -> tuple[str, ...]:
    name, timing = item
    return (name, f"{1 / timing.median:,.0f}", f"{timing.first:.1f}")


def _of(timings: Mapping[str, Timing], points: list[Point]) -> dict[Point, Timing]:
    return {point: timings[point.name] for point in points}


@dataclasses.dataclass(frozen=True)
class Memory:
    """Show how much device memory one control step needs, from the compiled program itself.

    Nothing is run, so programs for a card larger than this machine's can be measured too.
    """

    environment: tyro.conf.Positional[str] = "cube-double"
    """Environment."""
    engine: tuple[str, ...] = ("mjx-warp", "mjx-jax")
    """Physics engines."""
    simulations: tuple[int, ...] = (1, 64, 1024, 4096)
    """Simulations at once."""
    physics: str = "exact"
    """Physics profile."""
    card: float = 80.0
    """Memory of the card in question, in gigabytes."""

    def run(self) -> None:
        """Compile and print a table."""
        _check(*self.simulations)
        devices.backend()
        lines = []
        points = list(itertools.product(self.engine, self.simulations))
        with Progress("compiling", total=len(points), unit="programs") as progress:
            for engine, count in points:
                env = envs.make(self.environment, engine=engine, profile=self.physics)
                size = scaling.footprint(env, count)
                fitting = int(1e9 * self.card / size.total * count)
                each = f"{size.total / count / 1e3:,.1f}"
                lines.append(
                    (engine, f"{count:,}", f"{size.total / 1e6:,.1f}", each, f"{fitting:,}")
                )
                progress.advance(1, engine)
        header = ("engine", "simulations", "MB", "kB per simulation", f"fit in {self.card:g} GB")
        print(markdown_grid([header, *lines]))


def _check(*counts: int) -> None:
    for count in counts:
        if count < 1:
            raise UserError(f"simulations is {count}: it must be at least 1")
        memory.require(count)
