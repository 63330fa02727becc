"""`pigbench bench scale` and `bench memory`: the cost of more simulations and more cubes."""

import dataclasses
from pathlib import Path

import tyro

from pigbench import devices, envs
from pigbench.bench.turns import Turns, save, take_turns
from pigbench.errors import UserError, require
from pigbench.report.formats import markdown_grid
from pigbench.support import files, memory


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
    engine: str | None = None
    """Physics engine, by default the one for this device."""
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
        from pigbench.bench import scaling
        from pigbench.bench.scaling import Point
        from pigbench.report import canvas

        canvas.check_path(self.out)
        files.require_files(self.json)
        _check(*self.simulations, self.batch)
        engine = self.engine or envs.default_engine()
        grown = [Point(self.environment, count) for count in self.simulations]
        compared = [Point(name, self.batch) for name in self.environments]
        contenders = scaling.contenders([*grown, *compared], engine=engine, profile=self.physics)
        timings = take_turns("bench scale", contenders, self.turns)
        print(markdown_grid(scaling.table(timings)))
        scaling.draw(timings, grown, compared, self.out)
        print(f"{self.out} is drawn")
        save(self.json, dataclasses.replace(self, engine=engine), timings)


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
        from pigbench.bench import footprint

        require(self, lambda x: x > 0, "more than 0", "card")
        _check(*self.simulations)
        devices.backend()
        footprints = footprint.measure(
            self.environment, self.simulations, engines=self.engine, profile=self.physics
        )
        print(markdown_grid(footprint.table(footprints, card=self.card)))


def _check(*counts: int) -> None:
    for count in counts:
        if count < 1:
            raise UserError(f"simulations is {count}: it must be at least 1")
        memory.require_for(count)
