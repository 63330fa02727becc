"""`pigbench bench`: how long things take, side by side."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path

import jax
import tyro

from pigbench import agents
from pigbench.bench import training
from pigbench.bench.timing import Contender, Timing, alternate
from pigbench.errors import UserError
from pigbench.report.formats import markdown_grid
from pigbench.support import files
from pigbench.support.progress import Progress
from pigbench.training.provenance import surroundings


@dataclasses.dataclass(frozen=True)
class Turns:
    """How the contenders take turns; medians are over turns."""

    turns: int = 5
    """Turns of each contender."""
    seconds: float = 2.0
    """Length of a turn, in seconds."""

    def __post_init__(self) -> None:
        if self.turns < 1:
            raise UserError(f"turns is {self.turns}: it must be at least 1")


@dataclasses.dataclass(frozen=True)
class Train:
    """Time the updates of methods, and compare them with the first one's.

    On two cores or more, set XLA_FLAGS for the number of threads you mean to train with.
    """

    methods: tyro.conf.Positional[tuple[str, ...]] = ()
    """Methods, the first of which the others are compared with; by default all."""
    environment: str = "cube-single"
    """Environment whose observations and actions the networks take."""
    preset: str = "cpu"
    """Preset of hyper-parameters: cpu or paper."""
    turns: Turns = dataclasses.field(default_factory=Turns)
    """How the contenders take turns."""
    json: Path | None = None
    """File for the result as JSON, with machine and versions."""

    def run(self) -> None:
        """Measure and print a table."""
        contenders = training.contenders(
            self.environment, self.methods or agents.names(), self.preset
        )
        timings = _measure("bench train", contenders, self.turns)
        reference = next(iter(timings))
        print(
            markdown_grid(
                [
                    ("method", "ms an update", f"times {reference}", "s to compile"),
                    *(
                        (
                            name,
                            f"{1e3 * timing.median:.1f}",
                            f"{timing.ratio(timings[reference]):.2f}",
                            f"{timing.first - timing.median:.1f}",
                        )
                        for name, timing in timings.items()
                    ),
                ]
            )
        )
        _save(self.json, self, timings)


def _measure(task: str, contenders: list[Contender], turns: Turns) -> Mapping[str, Timing]:
    jax.config.update("jax_enable_compilation_cache", False)  # compilation is timed too
    total = (turns.turns + 1) * len(contenders)
    with Progress(task, total=total, unit="turns") as progress:
        return alternate(
            contenders,
            turns=turns.turns,
            seconds=turns.seconds,
            report=lambda name: progress.advance(1, name),
        )


def _save(path: Path | None, command: object, timings: Mapping[str, Timing]) -> None:
    if path is None:
        return
    settings = {name: value for name, value in vars(command).items() if name != "json"}
    settings["turns"] = dataclasses.asdict(settings["turns"])
    content = {
        "settings": settings,
        "seconds": {name: dataclasses.asdict(timing) for name, timing in timings.items()},
    }
    files.write_json(path, content | surroundings())
